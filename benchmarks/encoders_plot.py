"""The figures of `benchmarks.encoders` as a page and as a plot of time against error."""

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from omnivat.kit.errors import MissingPackageError
from omnivat.kit.tables import need

FLOOR = 1e-13  # an error below this is drawn here; rounding of the cosine itself is near it
CAPTION = (
    "Circles have the same bits as the default way, fp32 image by image; squares have not. "
    "Errors below 1e-13 are drawn there. The dashed line is the error that the list above allows."
)
ALLOWED = 1e-3  # largest 1 - cosine of an offered precision


def page(found: dict[str, Any]) -> str:
    """Return the rows as Markdown, with the machine and the conclusions."""
    place = found["machine"]
    lines = [
        "# Time and error of the encoders",
        "",
        f"Written by `python -m benchmarks.encoders --rounds {found['rounds']} --pictures "
        f"{found['pictures']} --batches {found['batches']} --out docs/benchmarks`.",
        f"{place['machine']} ({place['cpu']}; instructions for bf16: "
        f"{'yes' if place['bf16'] else 'no'}), shared; load {place['load']}; one thread; "
        f"torch {place['torch']}; {found['pictures']} pictures, medians of {found['rounds']} "
        "interleaved rounds (lowest to highest).",
        "Error is 1 - cosine to fp32 image by image, over generated pictures. CLIP's towers have "
        "random weights of the published sizes, so their errors are only a hint.",
        "",
        "| network | way | processor ms an image | wall ms | speed | error, median | error, worst | same bits |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| {row['network']} | {row['way']} "
        f"| {row['cpu_ms']:.1f} ({row['cpu_low']:.1f} to {row['cpu_high']:.1f}) "
        f"| {row['wall_ms']:.1f} ({row['wall_low']:.1f} to {row['wall_high']:.1f}) "
        f"| {row['speed']:.2f} | {row['error']:.1e} | {row['error_worst']:.1e} "
        f"| {'yes' if row['same_bits'] else 'no'} |"
        for row in found["rows"]
    ]
    networks = dict.fromkeys(row["network"] for row in found["rows"])
    verdicts = [verdict([r for r in found["rows"] if r["network"] == n]) for n in networks]
    return "\n".join([*lines, "", *verdicts, "", "![time against error](encoders.png)", "", CAPTION, ""])


def verdict(rows: Sequence[dict[str, Any]]) -> str:
    """Return the fastest way of a network with equal bits, and within the allowed error."""
    exact = max((r for r in rows if r["same_bits"]), key=lambda r: r["speed"])
    near = max((r for r in rows if r["error_worst"] <= ALLOWED), key=lambda r: r["speed"])
    return (
        f"- **{rows[0]['network']}**: fastest with the same bits: {exact['way']} "
        f"({exact['speed']:.2f} times fp32); fastest with a worst error up to {ALLOWED:g}: "
        f"{near['way']} ({near['speed']:.2f} times, {near['error_worst']:.0e})."
    )


def plot(rows: Sequence[dict[str, Any]], path: Path) -> None:
    """Draw worst error against CPU time for each image, one panel for each network."""
    try:
        matplotlib = need("matplotlib", purpose="the plot of the benchmark")
        pyplot = need("matplotlib.pyplot", purpose="the plot of the benchmark")
    except MissingPackageError as error:
        logging.getLogger(__name__).warning("%s", error)
        return
    matplotlib.use("Agg")
    networks = list(dict.fromkeys(row["network"] for row in rows))
    ways = list(dict.fromkeys(row["way"] for row in rows))
    colours = {way: pyplot.get_cmap("tab10")(i % 10) for i, way in enumerate(ways)}
    figure, axes = pyplot.subplots(1, len(networks), figsize=(3.7 * len(networks), 4.6), sharey=True, squeeze=False)
    seen: dict[str, Any] = {}
    for axis, network in zip(axes[0], networks, strict=True):
        for row in (r for r in rows if r["network"] == network):
            time, marker = row["cpu_ms"], "o" if row["same_bits"] else "s"
            seen[row["way"]] = axis.errorbar(
                time,
                max(row["error_worst"], FLOOR),
                xerr=[[time - row["cpu_low"]], [row["cpu_high"] - time]],
                fmt=marker,
                color=colours[row["way"]],
            )
        axis.axhline(ALLOWED, color="grey", linewidth=1, linestyle="--")
        axis.set(yscale="log", title=network, xlabel="processor ms an image, 1 thread")
        axis.set_xlim(left=0)
        axis.grid(alpha=0.3)
    axes[0][0].set_ylabel("worst error, 1 - cosine to fp32")
    figure.legend(seen.values(), seen, loc="lower center", ncol=3, fontsize=8, frameon=False)
    figure.tight_layout(rect=(0, 0.2, 1, 1))
    figure.savefig(path, dpi=130)
    pyplot.close(figure)
