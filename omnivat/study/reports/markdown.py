"""Markdown tables and the texts of their cells."""

import math
from collections.abc import Callable, Sequence

from omnivat.study.reports.intervals import Interval, Spread, spread
from omnivat.study.reports.reading import SCORES, Record, by_run, by_seed, completed, methods


def markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table; vertical bars in cells are escaped."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(c.replace("|", "\\|") for c in row) + " |" for row in lines)


def method_table(
    records: Sequence[Record],
    header: Sequence[str],
    cells: Callable[[list[Record]], list[str]],
    *,
    below: Sequence[Sequence[str]] = (),
) -> str:
    """Return a table with a row for each method: its label, and `cells` of its completed records;
    "" without a row.

    A method has no row if nothing of it was completed, or if it has no cells. `below`: finished
    rows.
    """
    named = [(label, completed(records, name)) for name, label in methods(records).items()]
    rows = [[label, *found] for label, own in named if own and (found := cells(own))]
    return markdown(["method", *header], [*rows, *below]) if rows or below else ""


def score_cell(runs: Sequence[Record], sources: Sequence[str], reading: str = "fused") -> str:
    """Return "57.3 ± 1.2 / 55.0 ± 1.0": ACC and Macro-F1 of one method's completed runs, the mean
    over sources and its spread over seeds.
    """
    each = (by_seed(by_run(runs, score, reading), sources) for score in SCORES)
    return " / ".join(spread_text(spread(values)) for values in each)


def percent(value: float) -> str:
    """Return a share as a percentage with one digit; a dash for NaN."""
    return "–" if math.isnan(value) else f"{100 * value:.1f}"


def spread_text(scores: Spread) -> str:
    """Return "57.3 ± 1.2" in percent; without ± for a single value."""
    if math.isnan(scores.std):
        return percent(scores.mean)
    return f"{percent(scores.mean)} ± {percent(scores.std)}"


def margin_text(values: Sequence[float | None], factor: float, digits: int) -> str:
    """Return the mean of the margins that there are, times `factor`; a dash for none."""
    there = [value for value in values if value is not None]
    return f"{factor * sum(there) / len(there):.{digits}f}" if there else "–"


def count_text(counts: Sequence[int]) -> str:
    """Return "259,469", or "259,405 to 259,469" if the counts differ; "" for none."""
    ends = sorted({min(counts), max(counts)}) if counts else []
    return " to ".join(f"{count:,}" for count in ends)


def interval_text(interval: Interval) -> str:
    """Return "+2.1 [0.4, 3.8]" in percentage points."""
    return f"{100 * interval.mean:+.1f} [{100 * interval.low:.1f}, {100 * interval.high:.1f}]"
