"""Explore: the whole set on a map that answers while p moves."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from app.components import component
from app.resources import Resources
from app.state import Recent, order_from
from omnivat.errors import DataError

if TYPE_CHECKING:
    import numpy as np

    from omnivat.data.store import Embeddings
    from omnivat.model.head import OmniVaT

    Array = np.ndarray[Any, Any]

TITLE = "Explore"
STAGES = ("raw", "frft", "relu", "f_bar", "f_hat")
NEIGHBOURS = 6
BATCH = 256  # pairs a step: bounds the memory of attention over a large set

_features: "Recent[Array]" = Recent(4)  # whole sets at one stage and order; about 8 MB each


def neighbours(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Return the points nearest to one point by cosine, in full width, not on the map.

    question  {"point": 0..2N-1 (VIS first, then TAC), "stage": …, "order": p}
    return    {"neighbours": [{"point", "cosine"}, …]}; the point's own pair may be among them

    Raises DataError for a point or stage that is not there.
    """
    embeddings = resources.embeddings()
    stage, point = str(question.get("stage")), question.get("point")
    if stage not in STAGES:
        raise DataError(f"No stage is called '{stage:.40}'; there are {', '.join(STAGES)}.")
    if not isinstance(point, int) or not 0 <= point < 2 * len(embeddings):
        raise DataError(f"No point has the number {point!r:.20}; choose one on the map.")
    order = order_from(question.get("order"))
    head = resources.head()
    order = head.model.order if order is None else order
    unitary = stage in ("raw", "frft")  # cosines do not depend on p: computed once
    key = f"{id(resources)} {'raw' if unitary else f'{stage} {order:.6f}'}"
    features = _features.get(key)
    if features is None:
        head.require_embeddings(embeddings)
        raw = unit_rows(embeddings) if unitary else staged(head.model, embeddings, stage, order)
        features = _features.keep(key, raw)
    return {"neighbours": nearest(features, point, NEIGHBOURS)}


def nearest(features: "Array", point: int, count: int) -> list[dict[str, Any]]:
    """Return the `count` rows with the largest cosine to row `point`, itself left out.

    features  (2N, D) rows of unit length
    """
    import numpy as np

    cosines = features @ features[point]
    cosines[point] = -np.inf
    count = min(count, len(cosines) - 1)
    best = np.argsort(-cosines, kind="stable")[:count]
    return [{"point": int(i), "cosine": round(float(cosines[i]), 4)} for i in best]


def unit_rows(embeddings: "Embeddings") -> "Array":
    """Return both modalities' embeddings (2N, D), each of length one."""
    import numpy as np

    both = np.concatenate([embeddings.vis, embeddings.tac]).astype(np.float32)
    lengths = np.linalg.norm(both, axis=1, keepdims=True)
    return both / np.maximum(lengths, 1e-12)


def staged(model: "OmniVaT", embeddings: "Embeddings", stage: str, order: float) -> "Array":
    """Return features (2N, D) of a stage at one order, each of length one."""
    import torch
    from torch.nn.functional import normalize

    parts: dict[str, list[torch.Tensor]] = {"vis": [], "tac": []}
    with torch.inference_mode():
        for start in range(0, len(embeddings), BATCH):
            rows = slice(start, start + BATCH)
            vis, tac = (torch.from_numpy(a[rows].copy()) for a in (embeddings.vis, embeddings.tac))
            out = model(vis, tac, order=order)
            for name, feature in getattr(out, stage).items():
                parts[name].append(normalize(feature.flatten(1), dim=-1))
    features: Array = torch.cat(parts["vis"] + parts["tac"]).numpy()
    return features


def build() -> None:
    """Lay the tab out."""
    component("explore")
