"""The figures of `benchmarks.encoders` as a table and as a plot of time against error."""

from collections.abc import Sequence
from html import escape
from math import log10
from typing import Any

FLOOR = 1e-9  # an error below this is drawn on the line "exact"
WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 760, 420, 90, 30, 20, 60
COLOURS = ("#1b6ca8", "#b5542b", "#4a7c3a")


def table(found: dict[str, Any]) -> str:
    """Return the rows as Markdown, with what they were measured on."""
    place = found["machine"]
    lines = [
        "# Time and error of the encoders",
        "",
        "Written by `python -m benchmarks.encoders --out docs/benchmarks`.",
        f"{place['machine']}, shared; load {place['load']}; one thread; torch {place['torch']}; "
        f"medians of {found['rounds']} interleaved rounds (lowest to highest).",
        "Error is 1 - cosine to fp32 over generated pictures. CLIP's towers have random weights of "
        "the published sizes, so their errors are only a hint.",
        "",
        "| network | way | processor ms an image | wall ms an image | error, median | error, worst |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| {row['network']} | {row['way']} "
        f"| {row['cpu_ms']:.1f} ({row['cpu_low']:.1f} to {row['cpu_high']:.1f}) "
        f"| {row['wall_ms']:.1f} ({row['wall_low']:.1f} to {row['wall_high']:.1f}) "
        f"| {row['error']:.1e} | {row['error_worst']:.1e} |"
        for row in found["rows"]
    ]
    return "\n".join([*lines, "", "![time against error](encoders.svg)", ""])


def plot(rows: Sequence[dict[str, Any]]) -> str:
    """Return an SVG: processor time an image to the right, worst error up, both logarithmic."""
    times = [row["cpu_ms"] for row in rows]
    errors = [max(row["error_worst"], FLOOR) for row in rows]
    across = _scale(min(times) / 1.5, max(times) * 3, LEFT, WIDTH - RIGHT)
    up = _scale(FLOOR / 2, max(*errors, 1e-3) * 3, HEIGHT - BOTTOM, TOP)
    names = list(dict.fromkeys(row["network"] for row in rows))
    body = [*_axes(across, up, times, errors)]
    for row, error in zip(rows, errors, strict=True):
        colour = COLOURS[names.index(row["network"]) % len(COLOURS)]
        x, y = across(row["cpu_ms"]), up(error)
        text = escape(f"{row['network']}: {row['way']}")
        body.append(f'<circle cx="{x:.0f}" cy="{y:.0f}" r="5" fill="{colour}"/>')
        # Points on one spot are told apart by writing their names at different heights.
        rise = 14 * (rows.index(row) % 3 - 1) if error == FLOOR else 0
        body.append(f'<text x="{x + 9:.0f}" y="{y + 4 + rise:.0f}" fill="{colour}">{text}</text>')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        'font-family="sans-serif" font-size="12">\n'
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>\n' + "\n".join(body) + "\n</svg>\n"
    )


def _scale(low: float, high: float, start: float, end: float) -> Any:
    def place(value: float) -> float:
        return start + (end - start) * (log10(value) - log10(low)) / (log10(high) - log10(low))

    return place


def _axes(across: Any, up: Any, times: list[float], errors: list[float]) -> list[str]:
    parts = []
    for value in (5, 10, 20, 50, 100, 200, 500, 1000):
        if min(times) / 1.5 <= value <= max(times) * 3:
            x = across(value)
            parts.append(
                f'<line x1="{x:.0f}" y1="{TOP}" x2="{x:.0f}" y2="{HEIGHT - BOTTOM}" stroke="#ddd"/>'
                f'<text x="{x:.0f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{value}</text>'
            )
    for power in range(round(log10(FLOOR)), 0):
        if 10**power <= max(*errors, 1e-3) * 3:
            y = up(10**power)
            label = "exact" if 10**power <= FLOOR else f"1e{power}"
            parts.append(
                f'<line x1="{LEFT}" y1="{y:.0f}" x2="{WIDTH - RIGHT}" y2="{y:.0f}" stroke="#ddd"/>'
                f'<text x="{LEFT - 8}" y="{y + 4:.0f}" text-anchor="end">{label}</text>'
            )
    middle = (LEFT + WIDTH - RIGHT) / 2
    parts.append(
        f'<text x="{middle:.0f}" y="{HEIGHT - 15}" text-anchor="middle">'
        "processor time an image, ms (one thread)</text>"
        f'<text x="20" y="{HEIGHT / 2:.0f}" text-anchor="middle" '
        f'transform="rotate(-90 20 {HEIGHT / 2:.0f})">worst error, 1 - cosine to fp32</text>'
    )
    return parts
