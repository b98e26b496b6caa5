"""Collect maps, curves and predictions stop by stop into one set of frames."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import torch
from torch import Tensor

from omnivat.data.embeddings import KEY
from omnivat.data.store import Embeddings
from omnivat.head.head import OmniVaT
from omnivat.head.predict_set import label_map
from omnivat.head.settings import HeadSettings
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.stages import STOPS, fitting
from omnivat.maps.frames.records import FEATURES, FrameSet, MapFrames, quantised
from omnivat.maps.projection import pca, torch_umap
from omnivat.maps.projection.quality import trust
from omnivat.maps.projection.torch_umap import aligned
from omnivat.maps.sweep import (
    MEASURES,
    STAGES,
    STILL,
    AtOrder,
    Features,
    curve_values,
    facts_of,
    walk,
)
from omnivat.measure.gaps.unit import unit
from omnivat.measure.shares import counted, mean_over_domains

METHODS = ("pca", "umap")
MOST_NAMES = 256  # an index is one byte
# of a set, in its frames
ENCODED = (*KEY, "simulated", "origin")


@dataclass(slots=True, eq=False)
class _Track:
    """The maps of one stage by one method."""

    method: str
    stage: str
    stops: tuple[int, ...]
    maps: list[Tensor] = field(default_factory=list)
    trust: list[float | None] = field(default_factory=list)

    def add(self, points: Tensor) -> None:
        """Map the next stop, aligned with the one before it."""
        before = self.maps[-1] if self.maps else None
        if self.method == "umap":
            flat = torch_umap.project(points, start=before)
        else:
            flat = pca.project(points)
            flat = flat if before is None else aligned(flat, before)
        self.maps.append(flat)
        self.trust.append(trust(points, flat))

    def frames(self) -> MapFrames:
        """Return the maps, quantised, with their trust."""
        flats = [flat.double().cpu().numpy() for flat in self.maps]
        return quantised(flats, self.stops, tuple(self.trust))


# curves of mean accuracy over unseen domains, by reading; `counted` chooses the pairs
NAMES = {"fused": "accuracy/unseen", "vis": "accuracy:vis/unseen", "tac": "accuracy:tac/unseen"}


class FrameBuilder:
    """Collects the results of each stop, in the order of the stops.

    settings  of the heads; all have the same classes and widths. None: no head, the raw stage alone
    still     stages whose distances do not depend on p: one map for all stops. Heads with a
              projection each, or an order for each modality, share the raw one alone
    """

    def __init__(
        self,
        settings: HeadSettings | None,
        embeddings: Embeddings,
        *,
        orders: Sequence[float],
        maps: Mapping[str, int],
        measures: Sequence[str],
        source: str,
        still: Sequence[str] = STILL,
    ) -> None:
        if not orders or any(after <= before for before, after in pairwise(orders)):
            raise SettingsError("orders must be one or more numbers, each above the one before it.")
        for name, stops in maps.items():
            method, _, stage = name.partition("/")
            if method not in METHODS or stage not in STAGES or stops < 1:
                raise SettingsError(
                    f"No map is called '{name}' with {stops} stops; name METHOD/STAGE of "
                    f"{', '.join(METHODS)} and {', '.join(STAGES)}, with 1 stop or more."
                )
        self.orders, self.embeddings, self.measures = tuple(orders), embeddings, measures
        self.source, self.still = source, still
        projects, known = (settings.projects, settings.classes) if settings else (True, ())
        # without a projection, the transform keeps the distances of the raw embedding
        shared = not projects and "frft" in still
        self.tracks = _tracks(maps, len(orders), shared=shared, still=still)
        wanted = {track.stage for track in self.tracks.values()}
        self.stages = [stage for stage in STAGES if stage in wanted]
        self.classes, self.facts = facts_of(embeddings, known)
        if max(len(self.classes), len(embeddings.header.domains)) > MOST_NAMES:
            raise DataError(
                f"Frames can have {MOST_NAMES} domains and classes; choose a smaller set."
            )
        self.curves: dict[str, list[float | None]] = {}
        self._label = label_map(known, embeddings.header.classes)[embeddings.label]
        self._counted = counted(embeddings, source) & (self._label >= 0)
        self._predictions: list[Any] = []
        self._confidences: list[Any] = []

    def add(self, at_order: AtOrder) -> None:
        """Add the next stop: features of the stages that depend on p, and predictions."""
        for track in set(self.tracks.values()):
            if at_order.index in track.stops:
                track.add(stacked(at_order.features[track.stage]))
        count = len(self.orders)
        for stage, name, value in curve_values(at_order, self.facts, self.measures):
            curve = self.curves.setdefault(name, [None] * count)
            known = value if np.isfinite(value) else None
            for place in range(count) if stage in self.still else [at_order.index]:
                curve[place] = known
        if "accuracy" in self.measures and self.source in self.embeddings.header.domains:
            for reading, shares in at_order.probabilities.items():
                if reading not in NAMES:
                    continue
                right = shares.argmax(1).cpu().numpy() == self._label
                share = mean_over_domains(right, self.embeddings, self.source, self._counted)
                curve = self.curves.setdefault(NAMES[reading], [None] * count)
                curve[at_order.index] = share
        nothing = torch.zeros(len(self.embeddings), 1)  # without a head
        confidence, predicted = at_order.probabilities.get("fused", nothing).max(1)
        self._predictions.append(predicted.to(torch.uint8).cpu().numpy())
        self._confidences.append((confidence * 255).round().to(torch.uint8).cpu().numpy())

    def finish(self, head: Mapping[str, Any]) -> FrameSet:
        """Return the frames. head: facts about the head."""
        for name, track in self.tracks.items():
            if name.endswith("/frft") and track.stage == "raw":  # its curves are the raw ones, too
                for curve, values in list(self.curves.items()):
                    measure, stage, *rest = curve.split("/")
                    if stage == "raw":
                        self.curves["/".join([measure, "frft", *rest])] = values
        frames = {track: track.frames() for track in set(self.tracks.values())}
        header = self.embeddings.header
        return FrameSet(
            orders=tuple(float(order) for order in self.orders),
            domains=header.domains,
            classes=self.classes,
            domain=self.facts.domains.cpu().numpy().astype(np.uint8),
            label=self.facts.labels.cpu().numpy().astype(np.uint8),
            prediction=np.stack(self._predictions),
            confidence=np.stack(self._confidences),
            maps={name: frames[track] for name, track in self.tracks.items()},
            curves=self.curves,
            head=dict(head),
            embeddings={n: getattr(header, n) for n in ENCODED},
        )


def stacked(features: Features) -> Tensor:
    """Return the unit rows of VIS, then those of TAC: (2N, W)."""
    return torch.cat([unit(features["vis"]), unit(features["tac"])])


def spread(stops: int, count: int) -> tuple[int, ...]:
    """Return at most `stops` of 0 .. count - 1, evenly spaced, with both ends if possible.

    >>> spread(3, 101)
    (0, 50, 100)
    """
    places = np.linspace(0, count - 1, min(stops, count)) if stops > 1 else np.zeros(1)
    return tuple(int(place) for place in np.rint(places))


def _tracks(
    maps: Mapping[str, int], count: int, *, shared: bool, still: Sequence[str]
) -> dict[str, _Track]:
    """Map each map name to its track; if `shared`, the DFrFT has that of the raw embedding."""
    made: dict[tuple[str, str], _Track] = {}
    tracks = {}
    for name, stops in maps.items():
        method, stage = name.split("/")
        source = "raw" if stage == "frft" and shared else stage
        chosen = spread(1 if source in still else stops, count)
        tracks[name] = made.setdefault((method, source), _Track(method, source, chosen))
    return tracks


PCA_STOPS, UMAP_STOPS = 128, 21  # PCA: more than 101 round stops and the learned order
# maps, and the largest number of evenly spaced stops of each
DEFAULT_MAPS: Mapping[str, int] = {
    **{f"pca/{stage}": PCA_STOPS for stage in STAGES},
    "umap/raw": 1,
    "umap/frft": UMAP_STOPS,
    "umap/f_hat": UMAP_STOPS,
}


def build_frames(
    model: OmniVaT | None,
    embeddings: Embeddings,
    *,
    orders: Sequence[float] = STOPS,
    maps: Mapping[str, int] = DEFAULT_MAPS,
    measures: Sequence[str] = MEASURES,
    still: Sequence[str] = STILL,
    provenance: Mapping[str, Any] | None = None,
    on_step: OnStep = ignore,
) -> FrameSet:
    """Compute the frames of a set of pairs, one order at a time.

    model       None: the features alone, one stop, with the maps and gaps of the raw stage
    orders      stops of the slider, in quarter turns, ascending
    maps        "method/stage" -> largest number of stops, evenly spaced with both ends; the page
                shows the nearest one
    still       stages with one map and one value for all stops: raw embedding and raw DFrFT,
                because the transform is unitary; ("raw",) for a model with an order for each
                modality
    measures    curves to compute, for the stages with a map; see docs/gaps.md
    provenance  facts about the head, apart from its learned order: hash, source domain
    Raises SettingsError for an unknown map or order, DataError for too many domains or classes.

    >>> from omnivat import EXAMPLES, load_embeddings, load_head
    >>> head = load_head(EXAMPLES / "chirps" / "head")
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors").sampled(40)
    >>> frames = build_frames(head.model, pairs, orders=(0, 0.5, 1), maps={"pca/f_hat": 3})
    >>> frames.pairs, frames.orders, [*frames.maps]
    (40, (0.0, 0.5, 1.0), ['pca/f_hat'])
    """
    known = dict(provenance or {})
    if model is None:
        orders, maps = (0.0,), {name: 1 for name in maps if name.endswith("/raw")}
    builder = FrameBuilder(
        model.settings if model else None,
        embeddings,
        orders=orders,
        maps=maps,
        measures=measures,
        source=str(known.get("source", "")),
        still=still,
    )
    for found in walk(
        model, embeddings, orders, stages=builder.stages, still=still, predictions=model is not None
    ):
        builder.add(found)
        on_step(
            Step(done=found.index + 1, total=len(orders), text=f"map at order {found.order:.2f}")
        )
    if model is None:
        return builder.finish({"kind": FEATURES, **known})
    known = {"fits": list(fitting(model.order, model.settings.width))} | known
    return builder.finish({"kind": "moved", "learned_order": model.order, **known})
