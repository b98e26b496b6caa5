"""Markdown tables and the format of their figures."""

import math
from collections.abc import Sequence

from omnivat.reports.intervals import Interval, Spread


def markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table; vertical bars in cells are escaped."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(c.replace("|", "\\|") for c in row) + " |" for row in lines)


def percent(value: float) -> str:
    """Return a share as a percentage with one digit; a dash for NaN."""
    return "–" if math.isnan(value) else f"{100 * value:.1f}"


def spread_text(found: Spread) -> str:
    """Return "57.3 ± 1.2" in percent; without ± for a single value."""
    if math.isnan(found.std):
        return percent(found.mean)
    return f"{percent(found.mean)} ± {percent(found.std)}"


def count_text(counts: Sequence[int]) -> str:
    """Return "259,469", or "259,405 to 259,469" if the counts differ; "" for none."""
    ends = sorted({min(counts), max(counts)}) if counts else []
    return " to ".join(f"{count:,}" for count in ends)


def interval_text(found: Interval) -> str:
    """Return "+2.1 [0.4, 3.8]" in percentage points."""
    mean = "–" if math.isnan(found.mean) else f"{100 * found.mean:+.1f}"
    ends = ", ".join("–" if math.isnan(v) else f"{100 * v:.1f}" for v in (found.low, found.high))
    return f"{mean} [{ends}]"
