"""Explore: the whole set on a map that follows p."""

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app import map_place
from app.limits import CENTRED_PAIRS
from app.resources import Resources
from app.state import order_from
from omnivat.data.packing import packed
from omnivat.errors import DataError
from omnivat.heads import kept_ladder

if TYPE_CHECKING:
    import numpy as np

    from omnivat.data.store import Embeddings
    from omnivat.model.head import OmniVaT

    Array = np.ndarray[Any, Any]

TITLE = "Explore"
NEIGHBOURS = 6
STEPS = 10_000  # of a share or a cosine: four digits


def neighbours(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Return the points nearest to one point by cosine, in full width, not on the map.

    question  {"point": 0..2N-1 (VIS first, then TAC), "stage": …, "order": p}
    return    {"neighbours": [{"point", "cosine"}, …]}; the point's own pair may be among them

    Raises DataError for an unknown point or stage.
    """
    from omnivat.sweep import STAGES

    embeddings = resources.embeddings()
    stage, point = str(question.get("stage")), question.get("point")
    if stage not in STAGES:
        raise DataError(f"No stage is called '{stage:.40}'; there are {', '.join(STAGES)}.")
    if type(point) is not int or not 0 <= point < 2 * len(embeddings):
        raise DataError(f"No point has the number {point!r:.20}; choose one on the map.")
    order = order_from(question.get("order"))
    return {"neighbours": nearest(kept_features(resources, stage, order), point, NEIGHBOURS)}


def kept_features(resources: Resources, stage: str, order: float | None) -> "Array":
    """Return the features of the first head at a stage, cached; the raw stage needs no head.

    order  None: the learned one
    """
    from omnivat.sweep import STILL

    embeddings, model = resources.embeddings(), None
    if stage != "raw":
        resources.head().require_embeddings(embeddings)
        model = resources.head().model
        order = model.order if order is None else order
    # unitary stages: their cosines do not depend on the order
    key = stage if stage in STILL else f"{stage} {order:.6f}"
    return resources.features.once(key, lambda: staged(model, embeddings, stage, order or 0.0))


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


def staged(model: "OmniVaT | None", embeddings: "Embeddings", stage: str, order: float) -> "Array":
    """Return the unit features (2N, W) of a stage at one order, VIS first; no model at "raw"."""
    import torch

    from omnivat.gaps.unit import unit
    from omnivat.sweep import walk

    with torch.inference_mode():
        found = next(walk(model, embeddings, [order], stages=[stage], predictions=False))
        rows = found.features[stage]
        features: Array = torch.cat([unit(rows["vis"]), unit(rows["tac"])]).numpy()
    return features


def unseen(resources: Resources) -> dict[str, Any]:
    """Return the accuracy of the first head in unseen domains; see `omnivat.unseen`.

    Values of each pair are `packed`: a list of numbers would need five times as many bytes.
    Raises DataError if head and set do not fit.
    """
    from omnivat.unseen import unseen_summary

    def made() -> dict[str, Any]:
        found = unseen_summary(resources.head(), resources.embeddings())
        known, width = found["pairs"], "u1" if len(found["classes"]) <= 256 else "u2"
        pairs = {
            "counts": packed(known["counts"], "u1"),
            "answers": {name: packed(labels, width) for name, labels in known["answers"].items()},
            "confidence": packed(known["confidence"], "u2", STEPS),
            "cosine": packed(known["cosine"], "i2", STEPS),
        }
        return {**found, "pairs": pairs}

    return resources.results.once("unseen", made)


def ladder(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Return the ladder of a source domain; see `omnivat.ladder`.

    question  {"source": a domain, "" for the head's}
    return    {"rungs": […], "sources": domains that have a ladder, the head's first}

    Raises DataError for a domain that the set lacks.
    """
    embeddings = resources.embeddings()
    source, domains = question.get("source"), embeddings.header.domains
    if not isinstance(source, str) or (source and source not in domains):
        raise DataError(f"The set has no domain {source!r:.40}; there are {', '.join(domains)}.")

    def climbed() -> dict[str, Any]:
        from omnivat.ladder import ladder

        where = resources.where
        kept = None if source or resources.drawn() else kept_ladder(where.head, where.embeddings)
        return kept or ladder(resources.head(), embeddings, source=source)

    return resources.results.once(f"ladder {source}", climbed)


def centred(resources: Resources, method: str) -> dict[str, Any]:
    """Return a map of the touches' raw embedding as it comes, and with each domain's mean taken away.

    method  "pca", or "umap", which takes seconds where no file has it
    return  the maps, as `omnivat.frames.centred.centred_reply` has them

    Raises DataError if the set is too large for maps on request.
    """
    from omnivat.frames.centred import centred_reply, kept_reply

    def made() -> dict[str, Any]:
        embeddings = resources.embeddings()
        if len(embeddings) > CENTRED_PAIRS:
            raise DataError(f"Domains are centred in sets of at most {CENTRED_PAIRS:,} pairs.")
        return kept_reply(resources.where.embeddings, embeddings, method) or centred_reply(embeddings, method)

    return resources.results.once(f"centred {method}", made)


def pairs(resources: Resources) -> dict[str, list[str]]:
    """Return the name of each pair and the classes it imitates, in the order of the set."""
    rows = resources.embeddings().rows
    names = [_name(file) for file in rows["vis"]]
    return {"name": names, **{column: rows[column] for column in ("looks_like", "feels_like")}}


def _name(file: str) -> str:
    """Return the common name of a pair's files."""
    return Path(file).stem.removesuffix("_vis")


@lru_cache(maxsize=1)
def _toy() -> dict[str, Any]:
    from omnivat.toy import toy

    return toy([k / 100 for k in range(101)])


def mechanism(resources: Resources) -> dict[str, Any]:
    """Return the toy for the transform and the ReLU; it is the same for every set."""
    return _toy()


def place(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Return the positions of a pair and its tree nodes on a map; see `app.map_place`."""
    return map_place.place(resources, question, kept_features)
