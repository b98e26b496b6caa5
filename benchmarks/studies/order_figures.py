"""Draw the figures of docs/order.md from the records of `benchmarks.studies.order` and `order_every`.

python -m benchmarks.studies.order_figures [--records DIR] [--out DIR]
"""

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.studies import order_controls, order_squares
from benchmarks.studies.order_every import rows_of
from benchmarks.studies.order_squares import MARGIN, Square
from benchmarks.studies.order_touch import ORDERS
from omnivat.figures.curves import lines
from omnivat.figures.scores import dots
from omnivat.figures.still import svg_of
from omnivat.study.reports.intervals import Spread, spread, spread_lines

Rows = list[dict[str, Any]]


def line_plot(title: str, across: str, ticks: list[str], series: Mapping[str, list[Spread]], unit: str = "%") -> str:
    """Return an SVG: one line for each series over evenly spaced places, bars of one std."""
    points = {name: spread_lines(found) for name, found in series.items()}
    return svg_of(lines(points, title=title, across=across, up=unit, ticks=ticks))


def curve_plot(title: str, across: str, up: str, curves: Mapping[str, Any]) -> str:
    """Return an SVG of curves: name -> (places, values)."""
    return svg_of(lines(curves, title=title, across=across, up=up))


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
                spread([_gain(row) for row in rows if (row["strength"], row["shift"]) == (value, shift)])
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
        {name: _scores(own, orders, shuffled) for name, shuffled in (("in order", False), ("permuted", True))},
    )


def _scores(rows: Rows, orders: Sequence[float], shuffled: bool) -> list[Spread]:
    return [spread([r["unseen"] for r in rows if (r["order"], r["permuted"]) == (order, shuffled)]) for order in orders]


def searched(rows: Rows) -> str:
    """Error of the closed-form classifier at every order of a search on the shipped chirps."""
    curve = rows[0]["curve"]
    points = sorted(zip(curve["orders"], curve["score"], curve["round"], strict=True))
    names = {"coarse": "steps of 1 / D", "fine": "around the three lowest valleys"}
    return curve_plot(
        "A search for p on the shipped chirps, p* = 0.35",
        "order p",
        "error on pairs left out (1: chance)",
        {
            name: tuple(zip(*((p, score) for p, score, kind in points if kind == key), strict=True))
            for key, name in names.items()
        },
    )


def every_order(rows: Rows) -> str:
    """Accuracy against p: heads of one stop and one head for every order, spread over sources."""
    names = {"noisy": "each stop, noise", "alone": "each stop", "every": "every, teachers", "plain": "every order"}
    light = [row for row in rows if row["width"] == 64]
    both = set.intersection(*({r["source"] for r in light if r["kind"] == kind} for kind in names))
    own = [row for row in light if row["source"] in both]
    stops = light[0]["stops"].split(",")
    return line_plot(
        "Accuracy in unseen domains, mean over sources, D = 64",
        "order p",
        stops,
        {
            name: [spread([row["unseen"][place] for row in own if row["kind"] == kind]) for place in range(len(stops))]
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
                spread([r["unseen"] for r in own if r["order"] == order and (r["shuffle"] is None) is kept])
                for order in orders
            ]
            for name, kept in (("samples in order", True), ("samples shuffled", False))
        },
    )


def touched(record: Mapping[str, Rows]) -> str:
    """Accuracy against p on vibrations, measured and simulated."""
    curves = {"BioTac, 20 materials": record["measured"][0]["accuracy"]}
    for row in record["simulated"]:
        if row["jitter"] == 0.02:
            curves[f"simulated, {row['acceleration']:g} mm/s²"] = row["accuracy"]
    return curve_plot(
        "Vibrations: accuracy against p",
        "order p of the transform",
        "%",
        {name: (list(ORDERS), [accuracy[f"p = {p:g}"] for p in ORDERS]) for name, accuracy in curves.items()},
    )


def squares(found: Sequence[Square]) -> str:
    """Accuracy of n orders less that of n seeds, with 90 % intervals over sources and the margin."""
    records = [
        {
            "row": f"{head}, {kind}, D = {width}, noise {noise:g}, n = {size}",
            **dict(zip(("value", "low", "high"), order_squares.less(rows), strict=True)),
        }
        for (head, kind, width, noise, size), rows in order_squares.summaries(found).items()
        if len(rows) > 1
    ]
    drawn = dots(
        records,
        title="Ensembles: orders less seeds, accuracy in unseen domains",
        across="points",
        ends=(-1.0, 1.0),
        level=MARGIN,
        caption=f"Bars: 90 % intervals over sources. Dashed: the margin, ± {MARGIN:g} points.",
    )
    other = drawn.layout.shapes[0].to_plotly_json() | {"x0": -MARGIN, "x1": -MARGIN}
    return svg_of(drawn.add_shape(other))


def unitaries(rows: Rows) -> str:
    """Accuracy on chirps with F_p and with other unitaries in its place: mean, lowest, highest."""
    names = {"order": "F_p at p*", "identity": "identity", "unitary": "random unitary", "group": "exp(pA), random A"}
    records = []
    for kind, name in names.items():
        own = [row["unseen"] for row in rows if row["kind"] == kind]
        ends = {"low": min(own), "high": max(own)}
        records.append({"row": f"{name} ({len(own)} heads)", "value": sum(own) / len(own), **ends})
    return svg_of(
        dots(
            records,
            title="Chirps: accuracy in unseen domains by transform",
            across="%",
            ends=(0, 100),
            level=20.0,
            caption="Dots: mean over heads. Bars: lowest to highest head. Dashed: chance.",
        )
    )


FIGURES: dict[str, tuple[str, Callable[[Rows], str]]] = {
    "order_basin": ("basin", basins),
    "order_width": ("basin", widths),
    "order_gain": ("strength", gains),
    "order_chirps": ("channels", lambda rows: controls(rows, "chirps", "Chirps")),
    "order_projected": ("channels", lambda rows: controls(rows, "projected", "Sensors, learned projection")),
    "order_unprojected": ("channels", lambda rows: controls(rows, "unprojected", "Sensors, 64 channels as they are")),
    "order_axis": ("axis", axes),
    "order_search": ("shipped", searched),
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
    if (record := options.records / "order_touch.json").is_file():
        written(options.out / "order_touch.svg", touched(json.loads(record.read_text("utf-8"))))
    written(options.out / "order_squares.svg", squares(order_squares.squares_of([order_squares.OUT])))
    written(options.out / "order_controls.svg", unitaries(rows_of(order_controls.OUT)))
    if rows := rows_of(options.records / "order_every.jsonl"):
        written(options.out / "order_every.svg", every_order(rows))


def written(file: Path, picture: str) -> None:
    """Write one figure and print its name."""
    file.write_text(picture, encoding="utf-8")
    print(file.name)


if __name__ == "__main__":
    main()
