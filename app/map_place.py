"""Positions of a pair on a map of the set, at one stop or at all, and the set's features."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from app.familiar import looked_at, predict_one
from app.modes import mode_files
from app.pair_input import asked, pair_of, rounded
from app.resources import Resources, state_of
from app.state import Lazy, Question, Reply, one_of, order_from
from omnivat.head.heads import OWN
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES, STAGES

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np

    from omnivat.head.checkpoint import Head
    from omnivat.maps.frames import FrameSet
    from omnivat.maps.journey import MapStop

    Array = np.ndarray[Any, Any]
    Maps = tuple[FrameSet, Callable[[], Iterable[MapStop]]]

OUTPUT = STAGES[-1]  # of the head, which the map of Try a pair shows
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
    named = asked(resources, question)
    head, file = _reader(resources, question)
    _, stops = _maps(resources, head, file)
    with one_thread():  # a second one waits more than it works
        found = journey(head, stops(), named.pair["vis"], named.pair["tac"])
    rows = {name: values[:, 0].numpy() for name, values in found.readings.items()}
    nodes = found.node_lengths.shape[-1]
    refs = [str(ref) for name in IMAGES if (ref := question.get(name))]
    by_own = OWN in resources.heads and all(ref.startswith("image:") for ref in refs)
    own = asked(resources, {**question, "head": OWN}) if by_own else None
    by_maps = own and {"classes": list(own.head.settings.classes), **predict_one(own)}
    return {
        "orders": found.orders,
        "stops": found.stops,
        "classes": list(head.settings.classes),
        "learned": head.model.order,
        "maps": {
            method: {
                "places": {name: rounded(rows[:, 0].numpy()) for name, rows in places.items()},
                "nodes": rounded(found.nodes[method][:, 0].numpy()),
                "exact": found.exact[method],
            }
            for method, places in found.places.items()
        },
        "readings": {name: rounded(values) for name, values in rows.items()},
        "tree": {
            "parents": parents(head.settings.generation, nodes),
            "in_use": head.settings.tree_at_inference,
            "probabilities": rounded(found.node_probabilities[:, 0].numpy()),
            "norms": rounded(found.node_lengths[:, 0].numpy()),
        },
        "images": looked_at(named),
        "own": by_maps,
    }


def place(resources: Resources, question: Question) -> Reply:
    """Place a pair on one map of the first head.

    question  {"vis", "tac": references, "order": p, "map": "pca" or "umap"}
    return    `points` by modality, each [x, y] in map units; `order` of the map's stop;
              `exact`: true if no position is an estimate: the pair is on the map, as an example
              of the set is, or the map is linear

    Raises DataError if there is no such map.
    """
    import numpy as np
    import torch

    from omnivat.maps.projection.neighbours import placed
    from omnivat.measure.gaps.unit import unit

    order, flat = _drawn(resources, question)
    refs, _, pair = pair_of(resources, question)
    halves = dict(zip(IMAGES, np.split(flat, 2), strict=True))
    points = {
        name: halves[name][row].tolist()
        for name, ref in refs.items()
        if ref and (row := resources.row_of(ref)) is not None
    }
    if points.keys() == {name for name, rows in pair.items() if rows is not None}:
        return {"points": points, "order": order, "exact": True}  # no features are needed
    with torch.inference_mode():
        own = resources.head().model(pair["vis"], pair["tac"], order=order).f_hat
    rows = torch.from_numpy(kept_features(resources, OUTPUT, order))
    found = placed(unit(torch.cat(list(own.values()))), rows, torch.from_numpy(flat))
    points = dict(zip(own, found.places.tolist(), strict=True)) | points
    return {"points": points, "order": order, "exact": found.exact}


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

    def made() -> "Maps":
        frames, embeddings = read_frames(file), resources.embeddings()

        def stops() -> "Iterable[MapStop]":
            few = len(embeddings) <= KEPT_PAIRS and head is resources.head()
            kept = resources.coefficients() if few else None
            return map_stops(head, embeddings, frames, kept=kept)

        size = 2 * len(embeddings) * head.settings.width * 4 * UMAP_STOPS
        return frames, stops if size > KEPT_STOPS else Lazy(lambda: list(stops()))

    return resources.drawn_frames.once(repr(state_of(file)), made)


def _drawn(resources: Resources, question: Question) -> "tuple[float, Array]":
    """Return the requested map of the head's output at its stop nearest to the requested order:
    order, positions (2N, 2).
    """
    kind, (frames, _) = str(question.get("map")), _maps(resources, *_reader(resources, {}))
    maps = frames.maps.get(f"{kind}/{OUTPUT}")
    if maps is None:
        raise DataError(f"There is no map '{kind:.20}' to place the pair on.")
    order = order_from(question.get("order"))
    wanted = resources.head().model.order if order is None else order
    stop = min(maps.orders, key=lambda at: abs(frames.orders[at] - wanted))
    return frames.orders[stop], maps.places(maps.orders.index(stop))


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

    return resources.features.once(key, staged)
