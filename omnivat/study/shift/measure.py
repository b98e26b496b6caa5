"""Gaps with intervals, retrieval both ways, and neighbours across domains, of unit rows."""

from collections.abc import Callable, Iterable, Mapping
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
    mean, n = float(values.mean()), len(values)
    return record(part, measure, mean, *place, low=low, high=high, n=n, note=note)


def record(
    part: str,
    measure: str,
    value: float,
    modality: str = "",
    first: str = "",
    second: str = "",
    *,
    low: float | None = None,
    high: float | None = None,
    n: int | str = "",
    note: str = "",
) -> Record:
    """Return one line of the table of numbers; `first` and `second` are its "from" and "to"."""
    place = {"modality": modality, "from": first, "to": second}
    more = {"low": low, "high": high, "n": n, "note": note}
    return {"part": part, "measure": measure, "value": value, **place, **more}


def gaps(features: Features, on_step: OnStep, measures: Iterable[str] = GAPS) -> list[Record]:
    """Return both gaps by some of `GAPS`, with jackknife intervals and a no-gap level.

    Means over domains (photos to touches) or over pairs of domains have intervals: a jackknife of
    BLOCKS blocks of objects. "no gap" is the same measure between two random halves of one domain.
    """
    places = {name: features.members(name) for name in features.domains}
    largest = sorted(places, key=lambda n: -len(places[n]))[:MOST_DOMAINS]
    rows = {m: features.rows(m) for m in features.modalities}
    members = {n: own for n, own in places.items() if n in largest and len(own) >= LEAST}
    objects = features.embeddings.objects
    random = np.random.default_rng(derive_seed(0, "blocks"))
    block = random.permutation(objects.max() + 1)[objects] % BLOCKS
    records = []
    for done, name in enumerate(measures):
        gap: Callable[[Tensor, Tensor], Tensor] = load(GAPS, name, kind="gap")
        each = []
        for left_out in range(-1, BLOCKS):  # -1: none
            kept = {d: own[block[own] != left_out] for d, own in members.items()}
            each.append(_of(rows, kept, gap))
            text = f"{name}, block {left_out + 1} of {BLOCKS}"
            on_step(Step(done=done * BLOCKS + left_out + 1, total=len(GAPS) * BLOCKS, text=text))
        records += _summed(name, *each)
        for modality, every in rows.items():
            level = floor(halves({n: every[own] for n, own in members.items()}), gap)
            if level is not None:
                note = "mean over domains of two random halves of one domain"
                records.append(record("no gap", name, level, modality, note=note))
    return records


Gaps = dict[tuple[str, str, str], float]  # modality ("" between modalities), domain, domain


def _of(rows: Mapping[str, Tensor], members: Mapping[str, Array], gap: Any) -> Gaps:
    """Return the gap between modalities in each domain, and between each two domains; NaN where a
    block left too few rows.
    """

    def value(a: Tensor, b: Tensor) -> float:
        try:
            return float(gap(a, b))
        except ShapeError:
            return float("nan")

    both = members.items() if len(rows) == 2 else ()
    between = {("", name, name): value(rows["vis"][own], rows["tac"][own]) for name, own in both}
    for modality, (a, b) in product(rows, combinations(members, 2)):
        between[modality, a, b] = value(rows[modality][members[a]], rows[modality][members[b]])
    return between


def _summed(measure: str, whole: Gaps, *parts: Gaps) -> list[Record]:
    """Return the means with intervals, then each value."""
    records = []
    for modality in dict.fromkeys(key[0] for key in whole):
        keys = [key for key in whole if key[0] == modality]
        part = "domain gap" if modality else "modality gap"
        mean, *others = (float(np.nanmean([values[k] for k in keys])) for values in (whole, *parts))
        half = T_BLOCKS * float(np.sqrt((BLOCKS - 1) * np.var(others)))
        low, high = max(0.0, mean - half), mean + half
        if measure == "proxy_a":
            high = min(2.0, high)
        note = f"mean, {len(keys)} {'pairs of domains' if modality else 'domains'}"
        records.append(record(part, measure, mean, modality, low=low, high=high, note=note))
        records += [record(part, measure, whole[m, a, b], m, a, b if m else "") for m, a, b in keys]
    return records


def retrieval(features: Features) -> list[Record]:
    """Return recall at DEPTHS, the median rank, and with classes mAP: photo to touch, and back.

    Each photo ranks all touches of its domain by cosine; its own touch is the one to find. A tie
    counts half. For mAP, every touch of the photo's class is right.
    """
    if len(features.modalities) < 2:
        return []
    vis, tac = features.rows("vis"), features.rows("tac")
    records, label, part = [], features.embeddings.label, "retrieval"
    for domain in features.domains:
        own = features.members(domain)
        count, objects = len(own), features.embeddings.objects[own]
        if count < 2:
            continue
        cosines = vis[own] @ tac[own].T
        for *ends, table in (("photo", "touch", cosines), ("touch", "photo", cosines.T)):
            place = domain, *ends
            right = table.diagonal()[:, None]
            ranks = ((table > right).sum(1) + ((table == right).sum(1) - 1) / 2 + 1).numpy()
            for k in DEPTHS:
                note = f"chance {min(1.0, k / count):.4f}"
                records.append(share(part, f"recall@{k}", ranks <= k, objects, *place, note=note))
            note = f"of {count}; chance {(count + 1) / 2:g}"
            middle = float(np.median(ranks))
            records.append(record(part, "median rank", middle, *place, n=count, note=note))
            if features.labelled:
                same = torch.from_numpy(label[own][:, None] == label[own][None])
                hits = same.gather(1, table.argsort(1, descending=True)).double()
                at = hits.cumsum(1) / torch.arange(1, count + 1)
                values = ((at * hits).sum(1) / hits.sum(1)).numpy()
                note = f"chance {float(same.double().mean()):.4f}"
                records.append(share(part, "mAP of the class", values, objects, *place, note=note))
    return records


def neighbours(features: Features) -> list[Record]:
    """Return how far domains mix, and whether the nearest pair of another domain has the class.

    The NEAR nearest rows of other objects: the share of the own domain, beside the share if domains
    were mixed. The nearest row of another domain: the share of the own class, beside chance.
    """
    domain, label, objects = (
        features.embeddings.domain,
        features.embeddings.label,
        features.embeddings.objects,
    )
    if len(features.domains) < 2:
        return []
    records, part = [], "neighbours"
    for modality in features.modalities:
        rows = features.rows(modality)
        home, level, right, chance = [], [], [], []
        for some in np.array_split(np.arange(len(rows)), -(-len(rows) // 512)):
            cosines = rows[some] @ rows.T
            same = domain[some][:, None] == domain[None]
            others = objects[some][:, None] != objects[None]
            apart = cosines.masked_fill(torch.from_numpy(~others), -2)
            near = apart.topk(min(NEAR, len(rows) - 1)).indices
            home.append(np.take_along_axis(same, near.numpy(), 1).mean(1))
            level.append((same & others).sum(1) / np.maximum(1, others.sum(1)))
            cosines[torch.from_numpy(same)] = -2
            right.append(label[cosines.argmax(1).numpy()] == label[some])
            alike = label[some][:, None] == label[None]
            chance.append((alike & ~same).sum(1) / np.maximum(1, (~same).sum(1)))
        mixed = float(np.concatenate(level).mean())
        values, what = np.concatenate(home), f"own domain among {NEAR} nearest"
        note = f"{mixed:.4f} if domains were mixed"
        records.append(share(part, what, values, objects, modality, note=note))
        for name in features.domains:
            own = features.members(name)
            records.append(share(part, what, values[own], objects[own], modality, name))
        if features.labelled:
            values, what = np.concatenate(right), "class of the nearest in another domain"
            note = f"chance {float(np.concatenate(chance).mean()):.4f}"
            records.append(share(part, what, values, objects, modality, note=note))
    return records
