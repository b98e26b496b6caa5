"""Write curves for other programs: JSON, or CSV with named columns."""

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from omnivat.files import replacing, write_json

Curves = Mapping[str, Sequence[float | None]]


def write_curves_json(
    path: str | Path, orders: Sequence[float], curves: Curves, head: Mapping[str, Any]
) -> None:
    """Write `{"orders": [...], "head": {...}, "curves": {name: [...]}}`; null means undefined."""
    plain = {name: [_number(value) for value in values] for name, values in curves.items()}
    write_json(path, {"orders": list(orders), "head": dict(head), "curves": plain})


def write_curves_csv(path: str | Path, orders: Sequence[float], curves: Curves) -> None:
    """Write a column `order`, then one column for each curve; an empty cell means undefined."""
    with replacing(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as handle:
        writer = csv.writer(handle)
        writer.writerow(["order", *curves])
        for order, *values in zip(orders, *curves.values(), strict=True):
            writer.writerow([order, *("" if (v := _number(x)) is None else v for x in values)])


def _number(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)
