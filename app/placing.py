"""Where a pair that is not in the set, or a tree's nodes, lie on a map of the set."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from app.asking import embedded, refs_from
from app.resources import Resources
from app.state import order_from
from omnivat.errors import DataError

if TYPE_CHECKING:
    import numpy as np

    Array = np.ndarray[Any, Any]

NEIGHBOURS = 15
EXACT = 1e-3  # of the map's radius: a linear map that fits every point this well is the map


def place(resources: Resources, question: Mapping[str, Any], features: Any) -> dict[str, Any]:
    """Place a pair, and the nodes of its tree where asked for, on one map of the first head.

    question  {"vis", "tac": references, "order": p, "stage": …, "map": "pca" or "umap",
              "nodes": whether to place the tree's nodes}
    features  (resources, stage, order) -> unit rows (2N, W) of the whole set
    return    `points` by modality and `nodes`, each [x, y] in map units; `order` of the map's
              stop; `exact`: whether the map is linear, so that the place is no estimate;
              `of_set`: whether all of the pair is of the set, and lies where the map has it

    Raises DataError where there is no such map.
    """
    from omnivat.frames import read_frames
    from omnivat.sweep.walk import stage_features

    stage, kind = str(question.get("stage")), str(question.get("map"))
    file = resources.frames.state().file
    if file is None:
        raise DataError("The map is still being computed; ask again when it is there.")
    frames = read_frames(file)
    drawn = frames.maps.get(f"{kind}/{stage}")
    if drawn is None:
        raise DataError(f"There is no map '{kind:.20}/{stage:.20}' to place the pair on.")
    wanted = order_from(question.get("order"))
    wanted = resources.head().model.order if wanted is None else wanted
    stop = min(drawn.orders, key=lambda at: abs(frames.orders[at] - wanted))
    order = frames.orders[stop]
    import torch

    flat = drawn.places(drawn.orders.index(stop))
    rows = features(resources, stage, order)
    refs = refs_from(question)
    pair = embedded(resources, refs)
    with torch.inference_mode():
        want_nodes = question.get("nodes") is True
        out = resources.head().model(pair["vis"], pair["tac"], order=order, nodes=want_nodes)
        if stage == "raw":
            own = {name: e.numpy() for name, e in pair.items() if e is not None}
        else:
            own = {name: e.numpy() for name, e in stage_features(out, stage).items()}
        nodes = out.nodes[0].numpy() if want_nodes and out.nodes is not None else None
    known = linear_map(rows, flat)
    placed = {name: on_map(e, rows, flat, known)[0].tolist() for name, e in own.items()}
    of_set = {
        name: int(ref.name) + (len(flat) // 2 if name == "tac" else 0)
        for name, ref in refs.items()
        if ref is not None and ref.kind == "row" and name in placed
    }
    placed |= {name: flat[row].tolist() for name, row in of_set.items()}
    return {
        "points": placed,
        "nodes": []
        if nodes is None or nodes.shape[1] != rows.shape[1]
        else on_map(nodes, rows, flat, known).tolist(),
        "order": order,
        "exact": known is not None,
        "of_set": of_set.keys() == placed.keys(),
    }


def linear_map(rows: "Array", flat: "Array") -> "Array | None":
    """Return the affine map (W + 1, 2) that takes rows (2N, W) to flat (2N, 2), None if none does.

    PCA is one, whatever turn or mirror follows it.
    """
    import numpy as np

    if len(rows) <= rows.shape[1] + 1:
        return None  # too few points to tell
    wide = np.concatenate([rows.astype(float), np.ones((len(rows), 1))], axis=1)
    found: Array = np.linalg.lstsq(wide, flat, rcond=1e-9)[0]
    radius = np.abs(flat - flat.mean(0)).max()
    off = np.abs(wide @ found - flat).max()
    return found if off <= EXACT * radius else None


def on_map(features: "Array", rows: "Array", flat: "Array", known: "Array | None") -> "Array":
    """Return places (B, 2) of features (B, W): by the linear map, or between nearest neighbours."""
    import numpy as np

    unit = features / np.maximum(np.linalg.norm(features, axis=1, keepdims=True), 1e-12)
    if known is not None:
        placed: Array = unit @ known[:-1] + known[-1]
        return placed
    cosines = unit @ rows.T
    count = min(NEIGHBOURS, len(rows))
    best = np.argpartition(-cosines, count - 1, axis=1)[:, :count]
    near = np.take_along_axis(cosines, best, axis=1)
    weights = np.exp(20 * (near - near.max(1, keepdims=True)))
    found: Array = (weights[..., None] * flat[best]).sum(1) / weights.sum(1)[:, None]
    return found
