"""Draw the figures of docs/order.md from the records of `benchmarks.order` and `order_every`.

python -m benchmarks.order_figures [--records DIR] [--out DIR]
"""

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks._curves import curve_plot
from benchmarks.order_every import rows_of
from omnivat.heads import EXAMPLES
from omnivat.reports.intervals import Spread, spread
from omnivat.reports.plot import line_plot

Rows = list[dict[str, Any]]


def basins(rows: Rows) -> str:
    """Loss against p - p0 for each width, for heads trained at p*."""
    own = [row for row in rows if row["p_star"] == row["trained_at"]]
    return curve_plot(
        "Loss against p, weights fixed",
        "p less the order that the head was trained at",
        "log loss",
        {f"D = {row['width']}": (row["offsets"], row["loss"]) for row in own},
    )


def widths(rows: Rows) -> str:
    """Half width of the valley times D."""
    own = [row for row in rows if row["p_star"] == row["trained_at"]]
    return line_plot(
        "Half width of the valley, times D",
        "width D of the head",
        [str(row["width"]) for row in own],
        {"half width · D": [spread([row["half_width"] * row["width"]]) for row in own]},
        unit="",
    )


def gains(rows: Rows) -> str:
    """Accuracy at p* minus the better of p = 0 and p = 1, against strength."""
    strengths = sorted({row["strength"] for row in rows})
    shifts = sorted({row["shift"] for row in rows})
    return line_plot(
        "Chirps: gain of the right order over p = 0 and p = 1",
        "norm of the interference over that of the signal",
        [f"{value:g}" for value in strengths],
        {
            f"shift {shift:g}": [
                spread(
                    [
                        _gain(row)
                        for row in rows
                        if (row["strength"], row["shift"]) == (value, shift)
                    ]
                )
                for value in strengths
            ]
            for shift in shifts
        },
        unit="points",
    )


def _gain(row: Mapping[str, Any]) -> float:
    unseen = row["unseen"]
    return float(unseen["p*"] - max(unseen["0"], unseen["1"]))


def controls(rows: Rows, kind: str, title: str) -> str:
    """Accuracy in unseen domains against p, channels in their order and permuted."""
    own = [row for row in rows if row["kind"] == kind]
    orders = sorted({row["order"] for row in own})
    return line_plot(
        title,
        "order p that the head was trained at",
        [f"{order:g}" for order in orders],
        {
            name: _scores(own, orders, shuffled)
            for name, shuffled in (("in order", False), ("permuted", True))
        },
    )


def _scores(rows: Rows, orders: Sequence[float], shuffled: bool) -> list[Spread]:
    return [
        spread([r["unseen"] for r in rows if (r["order"], r["permuted"]) == (order, shuffled)])
        for order in orders
    ]


def searched(head: Path) -> str:
    """Held-out log loss of the short trainings of a search, from the head's folder."""
    record = json.loads((head / "metrics.json").read_text(encoding="utf-8"))["order_search"]
    found = list(zip(record["orders"], record["score"], record["round"], strict=True))
    names = {"coarse": "21 orders", "fine": "7 around the best"}
    return curve_plot(
        "A search for p on chirps, p* = 0.35",
        "order p",
        "log loss of held-out pairs of the source",
        {
            name: (
                [p for p, _, kind in found if kind == key],
                [score for _, score, kind in found if kind == key],
            )
            for key, name in names.items()
        },
    )


def every_order(rows: Rows) -> str:
    """Accuracy against p: heads of one stop and one head for every order, spread over sources."""
    names = {
        "noisy": "each stop, noise",
        "alone": "each stop",
        "every": "every, teachers",
        "plain": "every order",
    }
    light = [row for row in rows if row["width"] == 64]
    both = set.intersection(*({r["source"] for r in light if r["kind"] == kind} for kind in names))
    own = [row for row in light if row["source"] in both]
    stops = light[0]["stops"].split(",")
    return line_plot(
        "Accuracy in unseen domains, mean over sources, D = 64",
        "order p",
        stops,
        {
            name: [
                spread([row["unseen"][place] for row in own if row["kind"] == kind])
                for place in range(len(stops))
            ]
            for kind, name in names.items()
        },
    )


def axes(rows: Rows) -> str:
    """Accuracy of a probe on the rows of tactile images, samples in order and shuffled."""
    own = [row for row in rows if row["kind"] == "rows of tactile images"]
    orders = sorted({row["order"] for row in own})
    return line_plot(
        "Rows of tactile images: accuracy in unseen domains",
        "order p of the transform",
        [f"{order:g}" for order in orders],
        {
            name: [
                spread(
                    [
                        r["unseen"]
                        for r in own
                        if r["order"] == order and (r["shuffle"] is None) is kept
                    ]
                )
                for order in orders
            ]
            for name, kept in (("samples in order", True), ("samples shuffled", False))
        },
    )


FIGURES: dict[str, tuple[str, Callable[[Rows], str]]] = {
    "order_basin": ("basin", basins),
    "order_width": ("basin", widths),
    "order_gain": ("strength", gains),
    "order_chirps": ("channels", lambda rows: controls(rows, "chirps", "Chirps")),
    "order_projected": (
        "channels",
        lambda rows: controls(rows, "projected", "Sensors, learned projection"),
    ),
    "order_unprojected": (
        "channels",
        lambda rows: controls(rows, "unprojected", "Sensors, 64 channels as they are"),
    ),
    "order_axis": ("axis", axes),
    "order_rows": ("channels", lambda rows: controls(rows, "rows", "Rows of the pictures")),
}


def main() -> None:
    """Draw every figure with a record."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=Path, default=Path("docs/benchmarks"))
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks"))
    options = parser.parse_args()
    for name, (study, draw) in FIGURES.items():
        record = options.records / f"order_{study}.json"
        if record.is_file():
            rows = json.loads(record.read_text(encoding="utf-8"))["rows"]
            written(options.out / f"{name}.svg", draw(rows))
    written(options.out / "order_search.svg", searched(EXAMPLES / "chirps" / "head"))
    if rows := rows_of(options.records / "order_every.jsonl"):
        written(options.out / "order_every.svg", every_order(rows))


def written(file: Path, picture: str) -> None:
    """Write one figure and print its name."""
    file.write_text(picture, encoding="utf-8")
    print(file.name)


if __name__ == "__main__":
    main()
