"""The records of the table of results: accuracies, their intervals, and paired differences.

A cell is accuracy in percent: the mean over sources of the mean over targets, over seeds. Its 95 %
interval draws sources, then the targets of each, then seeds, all with replacement (10,000 draws). A
difference is paired: both methods have the same source, target and seed. The mean of several heads
has no seed to draw, and there is one set, so sets are not drawn.
"""

import json
from collections import defaultdict
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.head.heads import LADDERS
from omnivat.kit.lines import lines
from omnivat.measure.ladder import FORMAT, letters, marks
from omnivat.study.protocol.records import FORMAT as RUN

ROOT = Path(__file__).resolve().parents[1]
RECORDS = ROOT / "docs" / "benchmarks"
CHIRPS = RECORDS / "chirps.jsonl.gz"
DRAWS = 10_000
BOTH = "+colours"  # after the name of a method by relief: a head of colours beside it
THREE = "three_maps"  # linear maps of photo, colours, relief and all three
WIDE = "wide_maps"  # linear maps of photo, colours beside relief in one vector, and both
Array = NDArray[Any]
# method -> accuracy in percent (sources, targets, seeds); NaN where absent
Cells = dict[str, Array]
Runs = dict[str, dict[tuple[int, int, int], float]]  # method -> (source, target, seed) -> the same


class Record:
    """The record's accuracies by method, rung, source, target and seed."""

    def __init__(self, file: Path = LADDERS) -> None:
        first, *runs = lines(file, FORMAT)
        self.runs = runs
        self.domains = first["domains"]
        self.domain = np.array(first["domain"])
        self.truth = letters(first["truth"])
        self.alike = np.array([flag == "1" for flag in first["look_alike"]])
        homes = (self.truth[self.domain == k] for k in range(len(self.domains)))
        self.learned = [np.isin(self.truth, home) for home in homes]  # the classes of a source
        self.cells = cache(self._cells)

    def _cells(self, rung: str, *, alike: bool = False) -> Cells:
        """Return accuracies of a rung; `alike`: of the pairs that look like another class only."""
        found: Runs = defaultdict(dict)
        for run in (run for run in self.runs if rung in run["answers"]):
            source = self.domains.index(run["source"])
            known = self.learned[source]
            counted = known & self.alike if alike else known
            right = np.where(counted, marks(run["answers"][rung], self.truth), np.nan)
            for target in range(len(self.domains)):
                rows = right[(self.domain == target) & ~np.isnan(right)]
                if (target == source) == (rung == "home") and len(rows):
                    found[run["method"]][source, target, run["seed"]] = 100 * float(rows.mean())
        return arranged(found, len(self.domains))

    def complete(self, names: Iterable[str]) -> list[str]:
        """Return the methods of which every source was measured, best first as they come."""
        cells, runs = self.cells("none"), {(r["method"], r["source"]) for r in self.runs}
        there = [n for n in names if all((n, source) in runs for source in self.domains)]
        return sorted(there, key=lambda name: -mean_of(cells[name]))

    def costs(self, name: str) -> tuple[str, str, str]:
        """Return seeds, seconds of a training and number of parameters of a method."""
        own = [run for run in self.runs if run["method"] == name]
        fit = "linear_maps" if name == "logistic" else name  # the two share one fit
        seconds = np.median([run["seconds"] for run in self.runs if run["method"] == fit])
        parameters = np.median([run["parameters"] for run in own])
        return str(len({run["seed"] for run in own})), f"{seconds:.0f}", f"{parameters:,.0f}"


def mean_of(cells: Array) -> float:
    """Return the mean over sources of the mean over targets and seeds."""
    return float(np.nanmean(np.nanmean(cells, axis=(1, 2))))


@cache
def _drawn(sources: int, targets: int, seeds: int) -> Array:
    """Return the places in a flat table of the values of each draw (DRAWS, values)."""
    random = np.random.default_rng(0)
    some = random.integers(sources, size=(DRAWS, sources))[..., None, None]
    drawn = random.integers(targets, size=(DRAWS, sources, targets))[..., None]
    seed = random.integers(seeds, size=(DRAWS, sources, 1, seeds))
    return ((some * targets + drawn) * seeds + seed).reshape(DRAWS, -1)


def interval(cells: Array) -> tuple[float, float, float]:
    """Return mean and 95 % interval of accuracies (sources, targets, seeds).

    A level of one value, such as the seed of a mean of several heads, is not drawn.
    """
    there = np.asarray(~np.isnan(cells).all(axis=2))
    targets = there.sum(1).min()  # the home cell of each source is empty
    dense = np.stack([cells[s][there[s]][:targets] for s in range(len(cells))])
    values = dense.ravel()[_drawn(*dense.shape)]
    mean = np.nanmean if np.isnan(dense).any() else np.mean  # the first is slower
    low, high = np.quantile(mean(values, axis=1), [0.025, 0.975])
    return mean_of(cells), float(low), float(high)


def with_interval(cells: Array, unit: str = "") -> str:
    """Return accuracy with its interval."""
    mean, low, high = interval(cells)
    return f"{mean:.1f}{unit} [{low:.1f}, {high:.1f}]"


def signed(mean: float, low: float, high: float) -> str:
    """Return a difference with its interval."""
    return f"{mean:+.1f} [{low:.1f}, {high:.1f}]".replace("-", "−")


def less(ours: Array, theirs: Array) -> str:
    """Return the paired difference with its interval, over the seeds that both have."""
    seeds = min(ours.shape[2], theirs.shape[2])
    return signed(*interval(ours[:, :, :seeds] - theirs[:, :, :seeds]))


def arranged(found: Runs, domains: int) -> Cells:
    """Return accuracies by source, target and seed as tables."""
    tables = {}
    for name, values in found.items():
        seeds = sorted({seed for *_, seed in values})
        tables[name] = np.full((domains, domains, len(seeds)), np.nan)
        for (source, target, seed), value in values.items():
            tables[name][source, target, seeds.index(seed)] = value
    return tables


def chirps() -> Cells:
    """Return method -> accuracies (sources, targets, seeds) on the shipped chirps."""
    runs, found = list(lines(CHIRPS, RUN)), defaultdict[str, Any](dict)
    names = sorted({run["source"] for run in runs})
    for run in runs:
        for target, scores in run["targets"].items():
            place = names.index(run["source"]), names.index(target), run["seed"]
            found[run["method"]][place] = 100 * scores["scores"]["fused"]["accuracy"]
    return arranged(found, len(names))


def twins() -> Cells:
    """Return method -> accuracies (sources, 1, 1) on twins: the sensor alone changed, touch alone.

    Dots are filled; sources are those that both methods learned.
    """
    split = json.loads((RECORDS / "twins.json").read_text(encoding="utf-8"))["split"]
    by_source = {m: split[m]["filled"]["touch"]["by_source"] for m in ("omnivat", "linear_maps")}
    shared = [source for source in by_source["omnivat"] if source in by_source["linear_maps"]]
    return {
        m: np.array([[[of[s]["home"] - of[s]["new_objects"] - of[s]["sensor"]]] for s in shared])
        for m, of in by_source.items()
    }


def real() -> dict[str, Any]:
    """Return what -> record of the real pairs of VT60."""
    records = json.loads((RECORDS / "real.json").read_text(encoding="utf-8"))["records"]
    return {record["what"]: record for record in records if record["part"] == "vt60"}
