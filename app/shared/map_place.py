"""A pair on the maps of the set at every stop of p, and the set's features."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from app.shared.familiar import looked_at, predict_one
from app.shared.modes import mode_files
from app.shared.pair_input import pair_request, rounded
from app.shared.resources import Resources, state_of
from app.shared.state import Lazy, Question, Reply, one_of
from omnivat.head.heads import OWN
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    from torch import Tensor

    from omnivat.head.checkpoint import Head
    from omnivat.maps.frames import FrameSet
    from omnivat.maps.journey import MapStop

    Array = np.ndarray[Any, Any]
    Maps = tuple[FrameSet, Callable[[], Iterable[MapStop]]]

DIGITS = 4  # of positions and probabilities
KEPT_STOPS = 64_000_000  # bytes of a set's features at all stops; more are computed each time


def journey(resources: Resources, question: Question) -> Reply:
    """Return a pair at every stop of a head's maps, as `omnivat.maps.journey` has it.

    question  {"vis", "tac": references; "head": a name, the first one if left out; or "mode": a
              mode of p whose frames and head stand next to the set}
    return    `orders` and `stops` of the frames (P); `classes`, `learned`; `maps`: method ->
              `places` by modality (P, 2), `nodes` (P, N, 2) in map units, and `exact`; `readings`:
              reading -> (P, K); `tree`: `parents`, `in_use`, `probabilities` (P, N, K), `norms`
              (P, N); `images`: the familiarity of each; `own`: `classes`, `readings` and `images`
              of the head for own pictures, null unless all pictures are the visitor's and there is
              such a head

    Raises DataError if the map is still being computed, head and set do not fit, or the weights of
    a mode are not there.
    """
    from omnivat.head.dtg import parents
    from omnivat.kit.threads import one_thread
    from omnivat.maps.journey import journey

    question = {**question, "head": question.get("head") or ""}
    named = pair_request(resources, question)
    head, file = _reader(resources, question)
    _, stops = _maps(resources, head, file)
    with one_thread():  # a second one waits more than it works
        found = journey(head, stops(), named.pair["vis"], named.pair["tac"])

    def plain(values: "Tensor") -> Any:  # of the only pair
        return rounded(values[:, 0].numpy(), DIGITS)

    nodes = found.node_lengths.shape[-1]
    refs = [str(ref) for name in IMAGES if (ref := question.get(name))]
    by_own = OWN in resources.heads and all(ref.startswith("image:") for ref in refs)
    own = pair_request(resources, {**question, "head": OWN}) if by_own else None
    by_maps = own and {"classes": list(own.head.settings.classes), **predict_one(own)}
    return {
        "orders": found.orders,
        "stops": found.stops,
        "classes": list(head.settings.classes),
        "learned": head.model.order,
        "maps": {
            method: {
                "places": {name: plain(rows) for name, rows in places.items()},
                "nodes": plain(found.nodes[method]),
                "exact": found.exact[method],
            }
            for method, places in found.places.items()
        },
        "readings": {name: plain(values) for name, values in found.readings.items()},
        "tree": {
            "parents": parents(head.settings.generation, nodes),
            "in_use": head.settings.tree_at_inference,
            "probabilities": plain(found.node_probabilities),
            "norms": plain(found.node_lengths),
        },
        "images": looked_at(named),
        "own": by_maps,
    }


def _reader(resources: Resources, question: Question) -> "tuple[Head, Path | None]":
    """Return the head that a question names, and the file of its frames that is there."""
    from omnivat.head.checkpoint import load_head

    mode = question.get("mode") or ""
    if not mode:
        head = resources.head_named(question.get("head"))
        return head, resources.frame_jobs[question.get("head") or ""].state().file
    file = mode_files(resources.where).get(one_of("mode", mode, mode_files(resources.where)))
    folder = file and file.with_suffix("")
    if not (folder and folder.is_dir()):
        raise DataError("The weights behind these frames are not here, so this pair has no tree.")
    return resources.mode_heads.once(mode, lambda: load_head(folder)), file


def _maps(resources: Resources, head: "Head", file: "Path | None") -> "Maps":
    """Return a head's frames, and what places pairs at their stops, kept for the next pair unless
    it is large. Raises DataError without frames.
    """
    from omnivat.maps.frames import read_frames
    from omnivat.maps.frames.builder import UMAP_STOPS
    from omnivat.maps.journey import map_stops
    from omnivat.maps.sweep.walk import KEPT_PAIRS

    if file is None:
        raise DataError("The map is still being computed; try again when it is there.")

    embeddings = resources.embeddings()
    size = 2 * len(embeddings) * head.settings.width * 4 * UMAP_STOPS

    def made() -> "Maps":
        frames = read_frames(file)

        def stops() -> "Iterable[MapStop]":
            few = len(embeddings) <= KEPT_PAIRS and head is resources.head()
            kept = resources.coefficients() if few else None
            return map_stops(head, embeddings, frames, kept=kept)

        return frames, stops if size > KEPT_STOPS else Lazy(lambda: list(stops()))

    key = f"{resources.holds} {state_of(file)}"
    return resources.shared.drawn_frames.once(key, made, min(size, KEPT_STOPS))


def kept_features(resources: Resources, stage: str, order: float | None) -> "Array":
    """Return the unit features (2N, W) of the first head at a stage, VIS first; "raw" needs no
    head.

    order  None: the learned one
    """
    import torch

    from omnivat.maps.sweep import STILL, walk
    from omnivat.maps.sweep.walk import KEPT_PAIRS
    from omnivat.measure.gaps.unit import unit

    embeddings, model = resources.embeddings(), None
    if stage != "raw":
        resources.head().require_embeddings(embeddings)
        model = resources.head().model
        order = model.order if order is None else order
    # unitary stages: their cosines do not depend on the order
    key = stage if stage in STILL else f"{stage} {order:.6f}"

    def staged() -> "Array":
        with torch.inference_mode():
            few = model is not None and len(embeddings) <= KEPT_PAIRS
            kept = resources.coefficients() if few else None
            at = [order or 0.0]
            found = next(walk(model, embeddings, at, stages=[stage], predictions=False, kept=kept))
            rows = found.features[stage]
            features: Array = torch.cat([unit(rows["vis"]), unit(rows["tac"])]).numpy()
        return features

    # those of the embedding are ten times as large as others, and made as fast as they are read
    return staged() if model is None else resources.features.once(key, staged)
