"""The benchmark of the fractional transform as a table and as a plot of error against time."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from omnivat.kit.errors import MissingPackageError
from omnivat.kit.tables import need

TASKS = ("build", "new p", "new x", "forward + backward")
PEER = "torch-frft dfrft"


def _cell(row: dict[str, Any]) -> str:
    time = row["time"]
    return f"{time['median']:.3g} ({time['low']:.3g} to {time['high']:.3g})"


def _sections(rows: list[dict[str, Any]]) -> Iterable[tuple[tuple[int, int, int], list[Any]]]:
    keys = dict.fromkeys((r["rows"], r["size"], r["threads"]) for r in rows)
    for key in keys:
        yield key, [r for r in rows if (r["rows"], r["size"], r["threads"]) == key]


def table(record: dict[str, Any]) -> str:
    """Markdown: a table for each size and number of threads."""
    about = record["machine"]
    lines = [
        "# The fractional transform: time and error",
        "",
        f"`python -m benchmarks.fractional` on a {about['machine']}, shared (load average "
        f"{about['load']} at the end), torch {about['torch']}.",
        "",
        "- **Times** are milliseconds: median (lowest to highest) of interleaved rounds, CPU time "
        "for one thread and wall clock for two. Calls shorter than 20 ms are repeated for as long, "
        "and their mean is one round.",
        "- **Error** is the worst relative error of three rows against 80-bit arithmetic, over "
        "p = 0.3, 1.7 and 1000.3.",
        "- **Share** is the time of N²B operations at the rate of a 1024 × 1024 matrix product, "
        "timed in the same rounds with the same threads, over the time of a new p.",
        "- **×** is the time of torch-frft's `dfrft` over that of the method.",
        "",
        "![Error against the time of a new p, all methods, with the Pareto front](fractional.png)",
        "",
    ]
    for (batch, size, count), rows in _sections(record["rows"]):
        lines += [f"## {batch} × {size}, {count} thread{'s' if count > 1 else ''}", ""]
        tasks = [task for task in TASKS if any(r["task"] == task for r in rows)]
        lines.append("| method | error | " + " | ".join(f"{t} | ×" for t in tasks) + " | share |")
        lines.append("| --- |" + " --- |" * (2 * len(tasks) + 2))
        for name in dict.fromkeys(r["method"] for r in rows):
            mine = {r["task"]: r for r in rows if r["method"] == name}
            peer = {r["task"]: r for r in rows if r["method"] == PEER}
            cells = []
            for task in tasks:
                row = mine.get(task)
                ratio = f"{peer[task]['time']['median'] / row['time']['median']:.1f}" if row and task in peer else ""
                cells.append(f"{_cell(row)} | {ratio}" if row else " | ")
            share = mine.get("new p", {}).get("share")
            error = next(iter(mine.values()))["error"]
            end = f"{share:.0%}" if share else ""
            lines.append(f"| {name} | {error:.1e} | " + " | ".join(cells) + f" | {end} |")
        lines.append("")
    return "\n".join(lines)


def pareto(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The Pareto front, by increasing first coordinate."""
    front: list[tuple[float, float]] = []
    for point in sorted(points):
        if not front or point[1] < front[-1][1]:
            front.append(point)
    return front


def plot(record: dict[str, Any], path: Path) -> None:
    """Error against the time of a new p on one thread, a panel for each size."""
    try:
        matplotlib = need("matplotlib", purpose="the plot of the benchmark")
        pyplot = need("matplotlib.pyplot", purpose="the plot of the benchmark")
    except MissingPackageError as error:
        logging.getLogger(__name__).warning("%s", error)
        return
    matplotlib.use("Agg")
    chosen = [r for r in record["rows"] if r["task"] == "new p" and r["threads"] == 1]
    sections = list(_sections(chosen))
    names = list(dict.fromkeys(r["method"] for r in chosen))
    colours = {name: pyplot.get_cmap("tab10")(i % 10) for i, name in enumerate(names)}
    figure, axes = pyplot.subplots(1, len(sections), figsize=(3.6 * len(sections), 4.4), sharey=True, squeeze=False)
    for axis, ((batch, size, _), rows) in zip(axes[0], sections, strict=True):
        for r in rows:
            time = r["time"]
            marker = "o" if r["method"].startswith("omnivat") else "s"
            axis.errorbar(
                time["median"],
                r["error"],
                xerr=[[time["median"] - time["low"]], [time["high"] - time["median"]]],
                fmt=marker,
                color=colours[r["method"]],
                label=r["method"],
            )
        front = pareto([(r["time"]["median"], r["error"]) for r in rows])
        axis.plot(*zip(*front, strict=True), "--", color="grey", linewidth=1, zorder=0)
        axis.set(xscale="log", yscale="log", title=f"{batch} × {size}", xlabel="new p, ms (1 thread)")
        axis.grid(alpha=0.3)
    axes[0][0].set_ylabel("relative error against 80-bit arithmetic")
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=3, fontsize=8, frameon=False)
    figure.tight_layout(rect=(0, 0.16, 1, 1))
    figure.savefig(path, dpi=130)
    pyplot.close(figure)
