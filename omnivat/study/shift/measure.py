"""Gaps with intervals, retrieval both ways, and neighbours across domains, of unit rows."""

from collections.abc import Callable, Mapping
from itertools import combinations, product
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.kit.errors import ShapeError
from omnivat.kit.progress import OnStep, Step
from omnivat.kit.seeding import derive_seed
from omnivat.kit.tables import load
from omnivat.measure.gaps import GAPS
from omnivat.measure.gaps.domain import floor, halves
from omnivat.study.shift.reading import Features

BLOCKS, T_BLOCKS = 8, 2.3646  # of objects; Student's 97.5 % quantile for 7 degrees of freedom
LEAST = 10  # pairs of a domain whose gaps are measured
MOST_DOMAINS = 12  # the largest, for gaps between domains
DEPTHS = (1, 5, 10)
NEAR = 10
DRAWS = 1000
Record = dict[str, Any]
Array = NDArray[Any]


def interval(values: Array, objects: Array) -> tuple[float, float]:
    """Return the 95 % interval of the mean of values (N,): a bootstrap of whole objects."""
    _, own = np.unique(objects, return_inverse=True)
    sums, sizes = np.bincount(own, values), np.bincount(own)
    if len(sums) < 2:
        return float("nan"), float("nan")
    random = np.random.default_rng(derive_seed(0, "objects"))
    drawn = random.integers(len(sums), size=(DRAWS, len(sums)))
    means = sums[drawn].sum(1) / sizes[drawn].sum(1)
    low, high = np.quantile(means, [0.025, 0.975])
    return float(low), float(high)


def share(
    part: str, measure: str, values: Array, objects: Array, *place: str, note: str = ""
) -> Record:
    """Return the record of a mean over pairs, with its interval."""
    low, high = interval(values, objects)
    return record(
        part, measure, float(values.mean()), *place, low=low, high=high, n=len(values), note=note
    )


def record(part: str, measure: str, value: float, *place: str, **more: Any) -> Record:
    """Return one line of the table of numbers.

    place  the columns "modality", "from" and "to", as many as are known
    more   the columns "low", "high", "n" and "note"
    """
    modality, first, second = (*place, "", "", "")[:3]
    where = {
        "part": part,
        "measure": measure,
        "value": value,
        "modality": modality,
        "from": first,
        "to": second,
    }
    return {**where, "low": None, "high": None, "n": "", "note": "", **more}


def gaps(features: Features, on_step: OnStep) -> list[Record]:
    """Return both gaps by every measure of `GAPS`, with jackknife intervals and a no-gap level.

    Means over domains (photos to touches) or over pairs of domains have intervals: a jackknife of
    BLOCKS blocks of objects. "no gap" is the same measure between two random halves of one domain.
    """
    sizes = {name: len(features.members(name)) for name in features.domains}
    largest = sorted(sizes, key=lambda n: -sizes[n])[:MOST_DOMAINS]
    rows = {m: features.rows(m) for m in features.modalities}
    members = {
        n: features.members(n) for n in features.domains if n in largest and sizes[n] >= LEAST
    }
    objects = features.objects
    random = np.random.default_rng(derive_seed(0, "blocks"))
    block = random.permutation(objects.max() + 1)[objects] % BLOCKS
    records = []
    for done, name in enumerate(GAPS):
        gap: Callable[[Tensor, Tensor], Tensor] = load(GAPS, name, kind="gap")
        whole = _of(rows, members, gap)
        parts = []
        for left_out in range(BLOCKS):
            parts.append(
                _of(rows, {d: own[block[own] != left_out] for d, own in members.items()}, gap)
            )
            text = f"{name}, block {left_out + 1} of {BLOCKS}"
            on_step(Step(done=done * BLOCKS + left_out + 1, total=len(GAPS) * BLOCKS, text=text))
        records += _summed(name, whole, parts) + _halves(name, rows, members, gap)
    return records


Gaps = dict[tuple[str, str, str], float]  # modality ("" between modalities), domain, domain


def _of(rows: Mapping[str, Tensor], members: Mapping[str, Array], gap: Any) -> Gaps:
    """Return the gap between modalities in each domain, and between each two domains."""
    found: Gaps = {}
    if len(rows) == 2:
        found = {
            ("", name, name): _one(gap, rows["vis"][own], rows["tac"][own])
            for name, own in members.items()
        }
    for modality, (a, b) in product(rows, combinations(members, 2)):
        found[modality, a, b] = _one(gap, rows[modality][members[a]], rows[modality][members[b]])
    return found


def _one(gap: Any, a: Tensor, b: Tensor) -> float:
    try:
        return float(gap(a, b))
    except ShapeError:  # a block left too few rows
        return float("nan")


def _summed(measure: str, whole: Gaps, parts: list[Gaps]) -> list[Record]:
    """Return the means with intervals, then each value."""
    records = []
    for modality in dict.fromkeys(key[0] for key in whole):
        keys = [key for key in whole if key[0] == modality]
        part = "domain gap" if modality else "modality gap"
        mean, *others = (float(np.nanmean([one[k] for k in keys])) for one in (whole, *parts))
        error = float(np.sqrt((BLOCKS - 1) * np.var(others)))
        most = 2.0 if measure == "proxy_a" else np.inf
        low, high = max(0.0, mean - T_BLOCKS * error), min(most, mean + T_BLOCKS * error)
        note = f"mean, {len(keys)} {'pairs of domains' if modality else 'domains'}"
        records.append(record(part, measure, mean, modality, low=low, high=high, note=note))
        records += [record(part, measure, whole[m, a, b], m, a, b if m else "") for m, a, b in keys]
    return records


def _halves(
    measure: str, rows: Mapping[str, Tensor], members: Mapping[str, Array], gap: Any
) -> list[Record]:
    found = []
    for modality, every in rows.items():
        level = floor(halves({name: every[own] for name, own in members.items()}), gap)
        if level is not None:
            note = "mean over domains of two random halves of one domain"
            found.append(record("no gap", measure, level, modality, note=note))
    return found


def retrieval(features: Features) -> list[Record]:
    """Return recall at DEPTHS, the median rank, and with classes mAP: photo to touch, and back.

    Each photo ranks all touches of its domain by cosine; its own touch is the one to find. A tie
    counts half. For mAP, every touch of the photo's class is right.
    """
    if len(features.modalities) < 2:
        return []
    vis, tac = features.rows("vis"), features.rows("tac")
    records, objects, label = [], features.objects, features.embeddings.label
    members = {
        domain: own for domain in features.domains if len(own := features.members(domain)) > 1
    }
    for domain, own in members.items():
        cosines = vis[own] @ tac[own].T
        for place, table in (
            ((domain, "photo", "touch"), cosines),
            ((domain, "touch", "photo"), cosines.T),
        ):
            right = table.diagonal()[:, None]
            ranks = ((table > right).sum(1) + ((table == right).sum(1) - 1) / 2 + 1).numpy()
            for k in DEPTHS:
                note = f"chance {min(1.0, k / len(own)):.4f}"
                records.append(
                    share("retrieval", f"recall@{k}", ranks <= k, objects[own], *place, note=note)
                )
            note = f"of {len(own)}; chance {(len(own) + 1) / 2:g}"
            records.append(
                record(
                    "retrieval",
                    "median rank",
                    float(np.median(ranks)),
                    *place,
                    n=len(own),
                    note=note,
                )
            )
            if features.labelled:
                same = torch.from_numpy(label[own][:, None] == label[own][None])
                hits = same.gather(1, table.argsort(1, descending=True)).double()
                at = hits.cumsum(1) / torch.arange(1, len(own) + 1)
                values, note = (
                    ((at * hits).sum(1) / hits.sum(1)).numpy(),
                    f"chance {float(same.double().mean()):.4f}",
                )
                records.append(
                    share("retrieval", "mAP of the class", values, objects[own], *place, note=note)
                )
    return records


def neighbours(features: Features) -> list[Record]:
    """Return how far domains mix, and whether the nearest pair of another domain has the class.

    The NEAR nearest rows of other objects: the share of the own domain, beside the share if domains
    were mixed. The nearest row of another domain: the share of the own class, beside chance.
    """
    domain, label, objects = features.embeddings.domain, features.embeddings.label, features.objects
    if len(features.domains) < 2:
        return []
    records = []
    for modality in features.modalities:
        rows = features.rows(modality)
        home, level, right, chance = [], [], [], []
        for some in np.array_split(np.arange(len(rows)), -(-len(rows) // 512)):
            cosines = rows[some] @ rows.T
            same = domain[some][:, None] == domain[None]
            others = objects[some][:, None] != objects[None]
            near = (
                cosines.masked_fill(torch.from_numpy(~others), -2)
                .topk(min(NEAR, len(rows) - 1))
                .indices
            )
            home.append(np.take_along_axis(same, near.numpy(), 1).mean(1))
            level.append((same & others).sum(1) / np.maximum(1, others.sum(1)))
            cosines[torch.from_numpy(same)] = -2
            right.append(label[cosines.argmax(1).numpy()] == label[some])
            alike = label[some][:, None] == label[None]
            chance.append((alike & ~same).sum(1) / np.maximum(1, (~same).sum(1)))
        mixed = float(np.concatenate(level).mean())
        values = np.concatenate(home)
        for name in ("", *features.domains):
            own = features.members(name) if name else np.arange(len(values))
            note, what = (
                f"{mixed:.4f} if domains were mixed" if not name else "",
                f"own domain among {NEAR} nearest",
            )
            records.append(
                share("neighbours", what, values[own], objects[own], modality, name, note=note)
            )
        if features.labelled:
            note, what = (
                f"chance {float(np.concatenate(chance).mean()):.4f}",
                "class of the nearest in another domain",
            )
            records.append(
                share("neighbours", what, np.concatenate(right), objects, modality, note=note)
            )
    return records
