"""Familiarity of a pair's images, and their nearest training pairs."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from app.pair_input import embedded, refs_from
from app.resources import Resources
from omnivat.errors import DataError

if TYPE_CHECKING:
    import numpy as np
    import torch

    from omnivat.checkpoint import Head

    Index = np.ndarray[Any, Any]

NEAREST = 3
UNLIKE = 0.05  # below this quantile, the prediction is a guess


def familiar(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Return the familiarity of each image of a pair.

    question  {"vis", "tac": references}
    return    `images`: modality -> `nearest`, the nearest training pairs of the loaded set and
              their cosines in E; and, if the head's folder has the training embeddings, `cosine`,
              `quantile` (share of the training images with a less similar nearest neighbour),
              `words` and `guess`; `of`: the set of the `nearest` pairs

    Raises DataError if the set has another encoder.
    """
    head, embeddings = resources.head(), resources.embeddings()
    head.require_embeddings(embeddings)
    refs = refs_from(question)
    pair = embedded(resources, refs)
    index, of = _training_pairs(resources)
    images: dict[str, dict[str, Any]] = {}
    for name, raw in pair.items():
        if raw is not None:
            own = refs[name]
            row = int(own.name) if own is not None and own.kind == "row" else -1
            images[name] = {"nearest": _nearest(resources, name, raw, index, row)}
    for name, looked in looked_at(head, pair["vis"], pair["tac"]).items():
        images[name] |= looked
    return {"images": images, "of": of}


def looked_at(
    head: "Head", vis: "torch.Tensor | None", tac: "torch.Tensor | None"
) -> dict[str, dict[str, Any]]:
    """Return modality -> cosine, quantile, words and guess of one pair's raw embeddings (1, D).

    Empty if the head's folder lacks the training embeddings.
    """
    if head.familiarity is None:
        return {}
    found = head.familiarity.look(vis, tac)[0]
    return {name: {**one, "guess": one["quantile"] < UNLIKE} for name, one in found.items()}


def _training_pairs(resources: Resources) -> "tuple[Index, str]":
    """Return the training rows of the set, and their description.

    If the set lacks the head's source, all rows.
    """
    import numpy as np

    embeddings, source = resources.embeddings(), resources.head().source
    if source not in embeddings.header.domains:
        return np.arange(len(embeddings)), "the loaded set"
    own = embeddings.domain == embeddings.header.domains.index(source)
    split = np.array(embeddings.rows["split"], dtype=object)
    keep = own & (split != "test")
    return np.flatnonzero(keep if keep.any() else own), f"the training pairs of {source}"


def _nearest(
    resources: Resources, name: str, raw: "torch.Tensor", index: "Index", own_row: int
) -> list[dict[str, Any]]:
    """Return the training pairs whose image is nearest by cosine in E, except the pair itself."""
    import torch

    from omnivat.gaps.unit import unit
    from omnivat.projection.neighbours import nearest

    if not len(index):
        raise DataError("The set has no pairs to compare with.")
    key = f"training {name}"
    rows = resources.features.get(key)
    if rows is None:
        vectors = torch.from_numpy(getattr(resources.embeddings(), name)[index].copy())
        rows = resources.features.keep(key, unit(vectors).numpy())
    query = unit(raw.float())
    found = nearest(torch.from_numpy(rows), min(NEAREST + 1, len(rows)), queries=query)
    near = [
        {"pair": int(index[i]), "cosine": round(1 - float(d) ** 2 / 2, 4)}
        for i, d in zip(found.index[0].tolist(), found.distance[0].tolist(), strict=True)
        if int(index[i]) != own_row
    ]
    return near[:NEAREST]
