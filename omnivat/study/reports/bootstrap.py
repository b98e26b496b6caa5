"""Hierarchical bootstrap over sources, seeds and test objects, from stored predictions.

One draw takes all sources with replacement, all seeds of each with replacement, and for each target
domain as many objects of each class as it has. All sources, seeds and methods share the objects
drawn for a domain, so differences are paired and a reused test set counts once.

Differences to many rows have simultaneous intervals d ± q s, where s is the bootstrap's standard
deviation of d and q the 95 % quantile of the largest |d* - d| / s over all rows (single-step
max-t). All intervals hold together in 95 % of repetitions, so the best row may be picked after the
fact.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.packing import DIGITS, unpacked
from omnivat.study.reports.intervals import Interval
from omnivat.study.reports.reading import SCORES, Record, completed

DRAWS = 2000
Array = NDArray[np.float64]
Row = tuple[str, str]  # method, and the name of a reading or fusion in `answers`


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Draws: sources (B, S), seeds (B, S, R), and weights (B, n) of a domain's objects."""

    sources: NDArray[np.int64]
    seeds: NDArray[np.int64]
    weights: Mapping[str, NDArray[np.float32]]
    objects: Mapping[str, list[int]]  # domain -> its objects, ascending

    def of(self, domain: str, target: Mapping[str, Any]) -> NDArray[np.float32]:
        """Return weights (1 + B, N) of a target's pairs: ones, then the draws."""
        columns = np.searchsorted(self.objects[domain], unpacked(target["objects"]))
        weights = self.weights[domain][:, columns]
        return np.concatenate((np.ones_like(weights[:1]), weights))


@dataclass(frozen=True, slots=True)
class Resampled:
    """A metric of one row, or a difference of two: its value, and its value in every draw (B,)."""

    value: float
    draws: Array

    def less(self, other: "Resampled") -> "Resampled":
        """Return the paired difference."""
        return Resampled(self.value - other.value, self.draws - other.draws)

    @property
    def spread(self) -> float:
        """The bootstrap's standard deviation."""
        return float(self.draws.std(ddof=1))


def complete_rows(records: Iterable[Record], readings: Sequence[str]) -> list[Row]:
    """Return the rows with stored predictions for all sources and seeds."""
    records = [r for r in records if "targets" in r]
    grid = {(r["source"], r["seed"]) for r in records}
    rows = []
    for method in dict.fromkeys(r["method"] for r in records):
        runs = completed(records, method)
        if {(r["source"], r["seed"]) for r in runs} != grid:
            continue
        answers = [target.get("answers", {}) for r in runs for target in r["targets"].values()]
        rows += [(method, name) for name in readings if all(name in target for target in answers)]
    return rows


def draws_for(records: Sequence[Record]) -> Draws:
    """Draw sources, seeds and objects, stratified by class, for records with stored predictions."""
    random = np.random.default_rng(0)
    sources, seeds = {r["source"] for r in records}, {r["seed"] for r in records}
    weights, objects = {}, {}
    for domain, classes in sorted(_objects(records).items()):
        objects[domain] = sorted(classes)
        named = np.array([classes[number] for number in objects[domain]])
        weights[domain] = np.zeros((DRAWS, len(named)), dtype=np.float32)
        for label in np.unique(named):
            count = int((named == label).sum())
            weights[domain][:, named == label] = random.multinomial(
                count, np.full(count, 1 / count), DRAWS
            )
    shape = (DRAWS, len(sources))
    drawn = random.integers(len(sources), size=shape)
    again = random.integers(len(seeds), size=(*shape, len(seeds)))
    return Draws(sources=drawn, seeds=again, weights=weights, objects=objects)


def _objects(records: Iterable[Record]) -> dict[str, dict[int, str]]:
    """Return domain -> object -> class, over all records."""
    classes: dict[str, dict[int, str]] = {}
    for record in records:
        for domain, target in record.get("targets", {}).items():
            if "objects" in target:
                names = [record["classes"][DIGITS.index(d)] for d in target["truth"]]
                pairs = zip(unpacked(target["objects"]), names, strict=True)
                classes.setdefault(domain, {}).update(pairs)
    return classes


def resampled(records: Sequence[Record], row: Row, drawn: Draws) -> dict[str, Resampled]:
    """Return ACC and Macro-F1 of a row: mean over targets, seeds and sources, in every draw."""
    method, reading = row
    runs = completed(records, method)
    sources, seeds = (sorted({r[key] for r in runs}) for key in ("source", "seed"))
    values = np.empty((len(SCORES), len(drawn.sources) + 1, len(sources), len(seeds)))
    for run in runs:
        cells = [
            _scores(target, reading, len(run["classes"]), drawn.of(domain, target))
            for domain, target in run["targets"].items()
        ]
        place = sources.index(run["source"]), seeds.index(run["seed"])
        values[:, :, *place] = np.mean(cells, axis=0)
    rows = np.arange(len(drawn.sources))[:, None, None]
    by_source = values[:, 1:][:, rows, drawn.sources[..., None], drawn.seeds].mean(-1)
    draws, point = by_source.mean(-1), values[:, 0].mean((-1, -2))
    return {name: Resampled(float(point[i]), draws[i]) for i, name in enumerate(SCORES)}


def _scores(
    target: Mapping[str, Any], reading: str, classes: int, weights: NDArray[np.float32]
) -> Array:
    """Return ACC and Macro-F1 over present classes (2, 1 + B) of weighted pairs."""
    eye = np.eye(classes, dtype=np.float32)
    truth, predicted = (
        eye[[DIGITS.index(digit) for digit in text]]
        for text in (target["truth"], target["answers"][reading])
    )
    right, true, said = weights @ (truth * predicted), weights @ truth, weights @ predicted
    f1 = 2 * right / np.maximum(true + said, 1e-9)
    accuracy = right.sum(1) / np.maximum(true.sum(1), 1e-9)
    return np.stack((accuracy, f1[:, truth.any(0)].mean(1))).astype(np.float64)


def simultaneous(ours: Resampled, others: Mapping[Row, Resampled]) -> dict[Row, Interval]:
    """Return simultaneous 95 % intervals (max-t) of ours minus each other row."""
    leads = {row: ours.less(other) for row, other in others.items()}
    scaled = [
        np.abs(lead.draws - lead.value) / lead.spread
        for lead in leads.values()
        if lead.spread > 1e-12
    ]
    factor = float(np.quantile(np.max(scaled, axis=0), 0.95)) if scaled else 0.0
    ends = {row: factor * lead.spread for row, lead in leads.items()}
    return {
        row: Interval(lead.value, lead.value - ends[row], lead.value + ends[row])
        for row, lead in leads.items()
    }


def percentile(ours: Resampled, other: Resampled) -> Interval:
    """Return the 95 % percentile interval of ours minus one row chosen beforehand."""
    lead = ours.less(other)
    low, high = np.quantile(lead.draws, [0.025, 0.975])
    return Interval(lead.value, float(low), float(high))
