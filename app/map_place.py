"""Positions of a pair on a map of the set, and the set's features at a stage."""

from typing import TYPE_CHECKING, Any

from app.pair_input import pair_of
from app.resources import Resources, state_of
from app.state import Question, Reply, order_from
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES, STAGES

if TYPE_CHECKING:
    import numpy as np

    Array = np.ndarray[Any, Any]

OUTPUT = STAGES[-1]  # of the head, which the map of Try a pair shows


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


def _drawn(resources: Resources, question: Question) -> "tuple[float, Array]":
    """Return the requested map of the head's output at its stop nearest to the requested order:
    order, positions (2N, 2).
    """
    from omnivat.maps.frames import read_frames

    kind = str(question.get("map"))
    file = resources.frames.state().file
    if file is None:
        raise DataError("The map is still being computed; try again when it is there.")
    frames = resources.drawn_frames.once(repr(state_of(file)), lambda: read_frames(file))
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
