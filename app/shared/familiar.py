"""Familiarity of a pair's images, and their nearest training pairs."""

from typing import TYPE_CHECKING, Any

from app.shared.mend import mend_in
from app.shared.pair_input import OTHER, PairRequest, pair_of, rounded
from app.shared.resources import Resources
from app.shared.state import Question, Reply
from omnivat.data.domains import titled

if TYPE_CHECKING:
    import numpy as np
    import torch

    from omnivat.head.checkpoint import Head

    Index = np.ndarray[Any, Any]

NEAREST = 3
MOST_LOOKED_AT = 2000  # pairs of the set among which the first one is chosen


def familiar(resources: Resources, question: Question) -> Reply:
    """Return the training pairs nearest to each image of a pair.

    question  {"vis", "tac": references; "head": a name}
    return    `images`: modality -> `nearest`, the nearest training pairs of the loaded set and
              their cosines in E; `strays`: true if an uploaded image is nearer to the training
              images of the other modality; `of`: the set of the `nearest` pairs

    Raises DataError if the set has another encoder.
    """
    import torch

    head = resources.head_named(question.get("head"))
    head.require_embeddings(resources.embeddings())
    refs, before, _ = pair_of(resources, {**question, "profile": ""})
    index, of = training_pairs(resources, head)
    images: dict[str, Reply] = {}
    for name, ref in refs.items():
        raw = before[name]
        if ref is None or raw is None:
            continue
        near = _nearest(resources, name, raw, index, resources.row_of(ref))
        images[name] = {"nearest": near}
        if ref.kind == "image" and not question.get("profile"):
            own = resources.embedding(ref, OTHER[name], mend_in(question))
            raw = torch.from_numpy(own.copy())[None]
            images[name]["strays"] = (
                _nearest(resources, OTHER[name], raw, index)[0]["cosine"] > near[0]["cosine"]
            )
    return {"images": images, "of": of}


def looked_at(named: PairRequest) -> dict[str, Reply]:
    """Return modality -> cosine, quantile, words and guess of a request's images before any
    profile.

    The quantile is the share of the known images with a less similar nearest neighbour. Empty if
    none is known.
    """
    from omnivat.head.calibration import UNLIKE

    if named.known is None:
        return {}
    looks = named.known.look(named.before["vis"], named.before["tac"])[0]
    return {name: {**look, "guess": look["quantile"] < UNLIKE} for name, look in looks.items()}


def predict_one(named: PairRequest) -> Reply:
    """Return `readings`, the class probabilities, and `images`, the familiarity, of a request's
    pair.
    """
    return {"readings": readings_of(named), "images": looked_at(named)}


def readings_of(named: PairRequest) -> dict[str, list[float]]:
    """Return reading -> the class probabilities of a request's pair."""
    import torch

    with torch.inference_mode():
        out = named.head.model(named.pair["vis"], named.pair["tac"], order=named.order)
        return {name: rounded(values.numpy())[0] for name, values in out.readings.items()}


def first(resources: Resources) -> Reply:
    """Return the pair to open with: the most familiar one that the head was not trained on.

    return  `ref` of an example, or else of a pair of the set; None if each would be a guess
    """
    import numpy as np
    import torch

    from omnivat.data.arrays import copied
    from omnivat.head.calibration import UNLIKE
    from omnivat.measure.shares import counted

    head, embeddings = resources.head(), resources.embeddings()
    head.require_embeddings(embeddings)
    tested = counted(embeddings, head.source)
    refs = {row: f"example:{name}" for name, row in resources.example_rows().items() if tested[row]}
    if not refs:
        refs = {int(row): f"row:{row}" for row in np.flatnonzero(tested)[:MOST_LOOKED_AT]}
    if head.familiarity is None or not refs:
        return {"ref": next(iter(refs.values()), None)}
    rows = np.array(list(refs))
    vis, tac = (
        torch.from_numpy(copied(getattr(embeddings, name)[rows])) for name in ("vis", "tac")
    )
    looks = head.familiarity.look(vis, tac)
    least = [min(image["quantile"] for image in look.values()) for look in looks]
    best = int(np.argmax(least))
    return {"ref": refs[int(rows[best])] if least[best] >= UNLIKE else None}


def training_pairs(resources: Resources, head: "Head") -> "tuple[Index, str]":
    """Return the rows of the set that a head learned from, or all if the set lacks one of its
    domains, and their description.
    """
    import numpy as np

    embeddings, source = resources.embeddings(), head.source
    domains, learned = embeddings.header.domains, head.provenance.get("domains", [source])
    if not set(learned) <= set(domains):
        return np.arange(len(embeddings)), "the loaded set"
    own = np.isin(embeddings.domain, [domains.index(name) for name in learned])
    split = np.array(embeddings.rows["split"], dtype=object)
    keep = own & (split != "test")
    return np.flatnonzero(keep if keep.any() else own), f"the training pairs of {titled(source)}"


def _nearest(
    resources: Resources, name: str, raw: "torch.Tensor", index: "Index", own_row: int | None = None
) -> list[Reply]:
    """Return the training pairs whose image is nearest by cosine in E, except the pair itself."""
    import torch

    from omnivat.data.arrays import copied
    from omnivat.measure.gaps.unit import unit

    def training() -> "Index":
        rows = torch.from_numpy(copied(getattr(resources.embeddings(), name)[index]))
        return unit(rows).half().numpy()  # the cosines that are sent have four digits

    rows = resources.features.once(f"training {name} {len(index)} {index[:1]}", training)
    cosines = torch.from_numpy(rows).float() @ unit(raw.float())[0]
    found = cosines.topk(min(NEAREST + 1, len(rows)))
    near = [
        {"pair": int(index[i]), "cosine": round(cosine, 4)}
        for cosine, i in zip(*(part.tolist() for part in found), strict=True)
        if int(index[i]) != own_row
    ]
    return near[:NEAREST]
