"""Tables of the accuracy of probes on a simulated set, with intervals over the sources."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.simulated_features import Features
from benchmarks.simulated_probe import FUSIONS, READINGS, Judged
from omnivat.data.domains import paper_name
from omnivat.study.reports.intervals import Interval, t_interval

Shares = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """One row of the table: its pairs, within the source or in other domains."""

    name: str
    within: bool
    chosen: NDArray[np.bool_]  # (N,)


def questions(features: Features) -> list[Question]:
    """Return the rows of the table, in order."""
    everything = np.ones(len(features.rows), dtype=bool)
    looks, feels = (features.column(name) != "" for name in ("looks_like", "feels_like"))
    groups = {
        "all pairs": everything,
        "imitate another class by sight": looks,
        "imitate another class by touch": feels,
        "imitate no class": ~looks & ~feels,
    }
    return [
        Question(name=f"{name}, {'within a domain' if within else 'other domains'}", within=within, chosen=chosen)
        for name, chosen in groups.items()
        if chosen.any()
        for within in (True, False)
    ]  # fmt: skip


def matrix(found: Judged, features: Features, reading: str, chosen: NDArray[np.bool_]) -> Shares:
    """Return the accuracy (S, S) from each source to each domain; NaN without pairs."""
    domains, materials = features.column("domain"), features.column("material")
    predicted = found.predictions[reading]
    shares = np.full((len(found.sources),) * 2, np.nan)
    for row in range(len(found.sources)):
        for column, target in enumerate(found.sources):
            tested = (domains == target) & chosen & (predicted[row] != "")
            if tested.any():
                shares[row, column] = (predicted[row] == materials)[tested].mean()
    return shares


def by_source(shares: Shares, *, within: bool) -> Shares:
    """Return a share for each source (S,): within it, or the mean over the other domains."""
    own = np.eye(len(shares), dtype=bool)
    return np.asarray(np.diag(shares) if within else np.nanmean(np.where(own, np.nan, shares), 1))


def chance(found: Judged, features: Features, *, within: bool) -> float:
    """Return the chance level of guessing a target's classes, averaged like the table."""
    domains, materials = features.column("domain"), features.column("material")
    shares = np.full((len(found.sources),) * 2, np.nan)
    for row in range(len(found.sources)):
        for column, target in enumerate(found.sources):
            tested = (domains == target) & (found.predictions["VIS"][row] != "")
            if tested.any():
                shares[row, column] = 1 / len(set(materials[tested]))
    return float(by_source(shares, within=within).mean())


def print_table(found: Judged, features: Features) -> None:
    """Print the main table, and the gain of fusion over each modality."""
    print("## Linear probes: means over the eight sources, %\n")
    print("| pairs | number | VIS | TAC | " + " | ".join(FUSIONS.values()) + " |")
    print("| --- | ---: |" + " ---: |" * len(READINGS))
    gains = []
    for question in questions(features):
        shares = {
            name: by_source(matrix(found, features, name, question.chosen), within=question.within) for name in READINGS
        }
        cells = [f"{100 * np.nanmean(shares[name]):.1f}" for name in READINGS]
        print(f"| {question.name} | {_counted(found, features, question)} | " + " | ".join(cells) + " |")
        gains.append((question.name, shares))
    within, across = (chance(found, features, within=inside) for inside in (True, False))
    print(f"\nChance: {100 * within:.1f} within a domain, {100 * across:.1f} in other domains.\n")
    _print_gains(gains)


def _counted(found: Judged, features: Features, question: Question) -> int:
    """Return the number of predictions of a row."""
    own = features.column("domain")[None, :] == np.array(found.sources)[:, None]
    tested = (found.predictions["VIS"] != "") & question.chosen & (own == question.within)
    return int(tested.sum())


def _print_gains(gains: list[tuple[str, dict[str, Shares]]]) -> None:
    print("## What fusing adds, points (95 % intervals over the sources, paired)\n")
    print("| pairs | fusion | over VIS alone | over TAC alone |\n| --- | --- | ---: | ---: |")
    for name, shares in gains:
        for fusion in FUSIONS:
            cells = [_shown(_gain(shares[fusion], shares[alone])) for alone in ("VIS", "TAC")]
            print(f"| {name} | {fusion} | " + " | ".join(cells) + " |")
    print()


def _gain(one: Shares, other: Shares) -> Interval:
    difference = one - other
    return t_interval(list(map(float, difference[np.isfinite(difference)])))


def _shown(gain: Interval) -> str:
    return f"{100 * gain.mean:+.1f} ({100 * gain.low:+.1f} to {100 * gain.high:+.1f})"


def print_matrix(found: Judged, features: Features, reading: str) -> None:
    """Print one reading's accuracy from each domain to each."""
    everything = np.ones(len(features.rows), dtype=bool)
    shares = 100 * matrix(found, features, reading, everything)
    print(f"## {FUSIONS.get(reading, reading)}: from each domain to each, %\n")
    print("| from \\ to | " + " | ".join(map(paper_name, found.sources)) + " | others |")
    print("| --- |" + " ---: |" * (len(found.sources) + 1))
    for row, source in enumerate(found.sources):
        cells = [f"**{c:.0f}**" if row == n else f"{c:.0f}" for n, c in enumerate(shares[row])]
        others = by_source(shares, within=False)[row]
        print(f"| {paper_name(source)} | " + " | ".join(cells) + f" | {others:.0f} |")
    print()


def print_imitations(found: Judged, features: Features) -> None:
    """Print the predicted classes of look-alikes and feel-alikes by each modality alone."""
    print("## Imitators: predicted as what they are, and as what they imitate (all sources, %)\n")
    print("| pairs | reading | own class | imitated class |\n| --- | --- | ---: | ---: |")
    materials = features.column("material")
    for column in ("looks_like", "feels_like"):
        other = features.column(column)
        for reading in ("VIS", "TAC", "product"):
            predicted = found.predictions[reading]
            tested = (predicted != "") & (other != "")
            if not tested.any():
                continue
            own, taken = ((predicted == names)[tested].mean() for names in (materials, other))
            print(f"| {column} | {reading} | {100 * own:.1f} | {100 * taken:.1f} |")
    print()
