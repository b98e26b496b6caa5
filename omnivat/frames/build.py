"""Build the page's frames: one exact map for each stop of the order, and the curves beside it.

Maps are of rows on the unit sphere, as the gaps are, VIS above TAC. PCA is taken anew at every
order, then turned or mirrored to lie nearest to the map before it; UMAP starts each map from the
one before it. Nothing is ever tweened.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import torch
from torch import Tensor

from omnivat.data.store import Embeddings
from omnivat.errors import DataError, SettingsError
from omnivat.frames.records import FrameSet, MapFrames, quantised
from omnivat.gaps.measures import STAGE_MEASURES
from omnivat.gaps.unit import unit
from omnivat.model.head import OmniVaT
from omnivat.progress import OnStep, Step, ignore
from omnivat.projection import chain, pca
from omnivat.projection.align import aligned
from omnivat.sweep import MEASURES, STAGES, STILL, Features, facts_of, measured, walk

METHODS = ("pca", "umap")
MOST_NAMES = 256  # an index is one byte
PCA_STOPS, UMAP_STOPS = 101, 21
DEFAULT_ORDERS = tuple(k / 100 for k in range(101))
# which maps, and at how many evenly spread stops at most
DEFAULT_MAPS: Mapping[str, int] = {
    **{f"pca/{stage}": PCA_STOPS for stage in STAGES},
    "umap/raw": 1,
    "umap/frft": 1,
    "umap/f_hat": UMAP_STOPS,
}


@dataclass(slots=True, eq=False)
class _Track:
    """The maps of one stage by one method, as they come."""

    method: str
    stage: str
    stops: tuple[int, ...]
    maps: list[Tensor] = field(default_factory=list)

    def add(self, points: Tensor, seed: int) -> None:
        """Map the next stop."""
        before = self.maps[-1] if self.maps else None
        self.maps.append(next_map(self.method, points, before, seed=seed))

    def frames(self) -> MapFrames:
        """Return the maps, quantised."""
        return quantised([flat.double().cpu().numpy() for flat in self.maps], self.stops)


def build_frames(
    model: OmniVaT,
    embeddings: Embeddings,
    *,
    orders: Sequence[float] = DEFAULT_ORDERS,
    maps: Mapping[str, int] = DEFAULT_MAPS,
    measures: Sequence[str] = MEASURES,
    provenance: Mapping[str, Any] | None = None,
    seed: int = 0,
    on_step: OnStep = ignore,
) -> FrameSet:
    """Compute all that the page draws for a set of pairs, one order at a time.

    orders      stops of the slider, in quarter turns, ascending
    maps        "method/stage" -> how many stops it has at most, spread evenly with both ends;
                the slider snaps to the nearest of them. Raw embedding and raw DFrFT have one map
                for all stops: the transform is unitary
    measures    curves to compute, for the stages that have a map; see docs/gaps.md
    provenance  what to write about the head beside its learned order: hash, source domain
    Raises SettingsError for a map or order that cannot be, DataError for sets too large to name.
    """
    _require(orders, maps, embeddings)
    tracks = _tracks(maps, len(orders), projects=model.settings.projects)
    wanted = {track.stage for track in tracks.values()}
    stages = [stage for stage in STAGES if stage in wanted]
    classes, facts = facts_of(embeddings, model.settings.classes, model.classifier.device)
    if max(len(classes), len(embeddings.header.domains)) > MOST_NAMES:
        raise DataError(f"Frames can name {MOST_NAMES} domains and classes; choose a smaller set.")
    curves: dict[str, list[float | None]] = {}
    predictions, confidences = [], []
    for found in walk(model, embeddings, orders, stages=stages, answers=True):
        for track in set(tracks.values()):
            if found.index in track.stops:
                track.add(stacked(found.features[track.stage]), seed)
        for stage, name, value in measured(found, facts, measures):
            curve = curves.setdefault(name, [None] * len(orders))
            known = value if np.isfinite(value) else None
            curve[:] = [known] * len(orders) if stage in STILL else curve
            curve[found.index] = known
        confidence, answer = found.probabilities["fused"].max(1)
        predictions.append(answer.to(torch.uint8).cpu().numpy())
        confidences.append((confidence * 255).round().to(torch.uint8).cpu().numpy())
        text = f"map at order {found.order:.2f}"
        on_step(Step(done=found.index + 1, total=len(orders), text=text))
    if "frft" in {name.split("/")[1] for name in maps} - set(stages):
        curves |= _renamed(curves, "raw", "frft")
    frames = {track: track.frames() for track in set(tracks.values())}
    header = embeddings.header
    return FrameSet(
        orders=tuple(float(order) for order in orders),
        domains=header.domains,
        classes=classes,
        domain=facts.domains.cpu().numpy().astype(np.uint8),
        label=facts.labels.cpu().numpy().astype(np.uint8),
        prediction=np.stack(predictions),
        confidence=np.stack(confidences),
        maps={name: frames[track] for name, track in tracks.items()},
        curves=curves,
        head={"learned_order": model.order, **(provenance or {})},
        embeddings={
            "encoder": header.encoder,
            "weights_hash": header.weights_hash,
            "simulated": header.simulated,
            "origin": header.origin,
        },
    )


def next_map(method: str, points: Tensor, before: Tensor | None, *, seed: int = 0) -> Tensor:
    """Return the map (2N, 2) of points (2N, W), to follow the map `before` of its neighbour."""
    if method == "pca":
        flat = pca.project(points)
        return flat if before is None else aligned(flat, before)
    return chain.following(points, before, seed=seed)


def stacked(features: Features) -> Tensor:
    """Return unit rows of VIS above those of TAC: (2N, W)."""
    return torch.cat([unit(features["vis"]), unit(features["tac"])])


def spread(stops: int, count: int) -> tuple[int, ...]:
    """Return at most `stops` of 0 .. count - 1, evenly spread, with both ends where two fit.

    >>> spread(3, 101)
    (0, 50, 100)
    """
    places = np.linspace(0, count - 1, min(stops, count)) if stops > 1 else np.zeros(1)
    return tuple(int(place) for place in np.rint(places))


def _tracks(maps: Mapping[str, int], count: int, *, projects: bool) -> dict[str, _Track]:
    """Return who makes which map: the raw DFrFT shares the raw embedding's, being unitary.

    Where the head projects embeddings first, the DFrFT is of the projected ones, and differs.
    """
    made: dict[tuple[str, str], _Track] = {}
    tracks = {}
    for name, stops in maps.items():
        method, stage = name.split("/")
        source = "raw" if stage == "frft" and not projects else stage
        chosen = spread(1 if stage in STILL else stops, count)
        tracks[name] = made.setdefault((method, source), _Track(method, source, chosen))
    return tracks


def _renamed(
    curves: Mapping[str, list[float | None]], of: str, to: str
) -> dict[str, list[float | None]]:
    """Return the curves of stage `of` under the name of stage `to`."""
    split = {name: name.split("/") for name in curves}
    return {
        "/".join([parts[0], to, *parts[2:]]): list(curves[name])
        for name, parts in split.items()
        if parts[1] == of and parts[0].split(":")[0] in STAGE_MEASURES
    }


def _require(orders: Sequence[float], maps: Mapping[str, int], embeddings: Embeddings) -> None:
    if not orders or any(after <= before for before, after in pairwise(orders)):
        raise SettingsError("orders must be one or more numbers, each above the one before it.")
    for name, stops in maps.items():
        method, _, stage = name.partition("/")
        if method not in METHODS or stage not in STAGES or stops < 1:
            raise SettingsError(
                f"No map is called '{name}' with {stops} stops; name METHOD/STAGE of "
                f"{', '.join(METHODS)} and {', '.join(STAGES)}, with 1 stop or more."
            )
    if not len(embeddings):
        raise DataError("There are no pairs to draw; choose a set with pairs.")
