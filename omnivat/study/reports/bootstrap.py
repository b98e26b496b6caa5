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
from omnivat.study.reports.reading import Record, completed

DRAWS = 2000
METRICS = ("accuracy", "macro_f1")
Array = NDArray[np.float64]
Row = tuple[str, str]  # method, and the name of a reading or fusion in `answers`


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Draws: sources (B, S), seeds (B, S, R), and weights of a domain's objects (B, n)."""

    sources: NDArray[np.int64]
    seeds: NDArray[np.int64]
    weights: Mapping[str, NDArray[np.float32]]
    places: Mapping[str, Mapping[int, int]]  # domain -> object -> its column

    def of(self, domain: str, target: Mapping[str, Any]) -> NDArray[np.float32]:
        """Return weights (1 + B, N) of a target's pairs: ones, then the draws."""
        columns = [self.places[domain][number] for number in unpacked(target["objects"])]
        return np.concatenate(
            (np.ones((1, len(columns)), dtype=np.float32), self.weights[domain][:, columns])
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Resampled:
    """A metric of one row: its value, and its value in every draw (B,)."""

    value: float
    draws: Array


def complete_rows(records: Iterable[Record], readings: Sequence[str]) -> list[Row]:
    """Return the rows with stored predictions for all sources and seeds."""
    records = [r for r in records if "targets" in r]
    grid = {(r["source"], r["seed"]) for r in records}
    rows = []
    for method in dict.fromkeys(r["method"] for r in records):
        own = completed(records, method)
        if {(r["source"], r["seed"]) for r in own} != grid:
            continue
        for reading in readings:
            if all(reading in t.get("answers", {}) for r in own for t in r["targets"].values()):
                rows.append((method, reading))
    return rows


def draws_for(records: Sequence[Record], *, draws: int = DRAWS) -> Draws:
    """Draw sources, seeds and objects, stratified by class, for records with stored predictions."""
    random = np.random.default_rng(0)
    sources, seeds = {r["source"] for r in records}, {r["seed"] for r in records}
    weights, places = {}, {}
    for domain, classes in sorted(_objects(records).items()):
        order = sorted(classes)
        counts = np.zeros((draws, len(order)), dtype=np.float32)
        for label in sorted(set(classes.values())):
            own = [i for i, name in enumerate(order) if classes[name] == label]
            counts[:, own] = random.multinomial(len(own), np.full(len(own), 1 / len(own)), draws)
        weights[domain], places[domain] = counts, {name: i for i, name in enumerate(order)}
    shape = (draws, len(sources))
    drawn, again = (
        random.integers(len(sources), size=shape),
        random.integers(len(seeds), size=(*shape, len(seeds))),
    )
    return Draws(sources=drawn, seeds=again, weights=weights, places=places)


def _objects(records: Iterable[Record]) -> dict[str, dict[int, str]]:
    """Return domain -> object -> class, over all records."""
    found: dict[str, dict[int, str]] = {}
    for record in records:
        for domain, target in record.get("targets", {}).items():
            if "objects" in target:
                names = [record["classes"][DIGITS.index(d)] for d in target["truth"]]
                own = found.setdefault(domain, {})
                own |= dict(zip(unpacked(target["objects"]), names, strict=True))
    return found


def resampled(records: Sequence[Record], row: Row, drawn: Draws) -> dict[str, Resampled]:
    """Return ACC and Macro-F1 of a row: mean over targets, seeds and sources, in every draw."""
    method, reading = row
    own = completed(records, method)
    sources = sorted({r["source"] for r in own})
    seeds = sorted({r["seed"] for r in own})
    values = np.empty((len(METRICS), len(drawn.sources) + 1, len(sources), len(seeds)))
    for record in own:
        targets, count = record["targets"], len(record["classes"])
        cells = [
            _scores(target, reading, count, drawn.of(domain, target))
            for domain, target in targets.items()
        ]
        values[:, :, sources.index(record["source"]), seeds.index(record["seed"])] = np.mean(
            cells, axis=0
        )
    rows = np.arange(len(drawn.sources))[:, None]
    by_seed = values[:, 1:][:, rows[..., None], drawn.sources[..., None], drawn.seeds].mean(-1)
    draws, point = by_seed.mean(-1), values[:, 0].mean((-1, -2))
    return {
        name: Resampled(value=float(point[i]), draws=draws[i]) for i, name in enumerate(METRICS)
    }


def _scores(
    target: Mapping[str, Any], reading: str, classes: int, weights: NDArray[np.float32]
) -> Array:
    """Return ACC and Macro-F1 over present classes (2, 1 + B) of weighted pairs."""
    eye = np.eye(classes, dtype=np.float32)
    truth = eye[[DIGITS.index(d) for d in target["truth"]]]
    predicted = eye[[DIGITS.index(d) for d in target["answers"][reading]]]
    right = weights @ (truth * predicted)
    wanted, given = weights @ truth, weights @ predicted
    present = truth.any(0)
    f1 = 2 * right / np.maximum(wanted + given, 1e-9)
    accuracy = right.sum(1) / np.maximum(wanted.sum(1), 1e-9)
    return np.stack((accuracy, f1[:, present].mean(1))).astype(np.float64)


def simultaneous(ours: Resampled, others: Mapping[Row, Resampled]) -> dict[Row, Interval]:
    """Return simultaneous 95 % intervals (max-t) of ours minus each other row."""
    means = {row: ours.value - other.value for row, other in others.items()}
    draws = {row: ours.draws - other.draws for row, other in others.items()}
    spreads = {row: float(d.std(ddof=1)) for row, d in draws.items()}
    scaled = [
        np.abs(draws[row] - means[row]) / spreads[row] for row in others if spreads[row] > 1e-12
    ]
    factor = float(np.quantile(np.max(scaled, axis=0), 0.95)) if scaled else 0.0
    ends = {
        row: (means[row] - factor * spreads[row], means[row] + factor * spreads[row])
        for row in others
    }
    return {
        row: Interval(mean=means[row], low=a, high=b, n=len(ours.draws))
        for row, (a, b) in ends.items()
    }


def percentile(ours: Resampled, other: Resampled) -> Interval:
    """Return the 95 % percentile interval of ours minus one row chosen beforehand."""
    differences = ours.draws - other.draws
    low, high = np.quantile(differences, [0.025, 0.975])
    return Interval(
        mean=ours.value - other.value, low=float(low), high=float(high), n=len(differences)
    )
