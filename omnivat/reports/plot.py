"""Line plots with error bars as SVG, without a plotting package."""

from collections.abc import Mapping, Sequence
from html import escape
from math import ceil, floor, isnan

from omnivat.reports.intervals import Spread

WIDTH, HEIGHT = 420, 280
LEFT, RIGHT, TOP, BOTTOM = 52, 12, 34, 40
COLOURS = ("#0b62a4", "#b3480b", "#3d7a1f", "#7a3d9c")  # all at least 4.5:1 on white


def line_plot(
    title: str,
    axis: str,
    places: Sequence[str],
    series: Mapping[str, Sequence[Spread]],
    unit: str = "%",
) -> str:
    """Return an SVG: one line for each series over evenly spaced places, bars of one std.

    title   shown on top, and the picture's accessible name
    axis    label of the axis
    places  labels of the places
    series  name -> one Spread for each place, in the unit shown (57.3 for 57.3 %)
    """
    ends = [
        value
        for spreads in series.values()
        for s in spreads
        for value in (s.mean - _bar(s), s.mean + _bar(s))
        if not isnan(value)
    ]
    low, high = _limits(ends)
    parts = [_frame(title, axis, unit, low, high), _ticks(places)]
    for index, (name, spreads) in enumerate(series.items()):
        parts.append(_series(name, spreads, index, len(places), low, high))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'font-family="sans-serif" font-size="11"><title>{escape(title)}</title>'
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>' + "".join(parts) + "</svg>\n"
    )


def _bar(found: Spread) -> float:
    return 0.0 if isnan(found.std) else found.std


def _limits(values: Sequence[float]) -> tuple[float, float]:
    if not values:
        return 0.0, 1.0
    low, high = min(values), max(values)
    step = 5.0 if high - low > 10 else 1.0
    low, high = step * floor(low / step), step * ceil(high / step)
    return low, high if high > low else low + step


def _x(place: int, count: int) -> float:
    span = WIDTH - LEFT - RIGHT
    return LEFT + span * (place + 0.5) / count


def _y(value: float, low: float, high: float) -> float:
    return TOP + (HEIGHT - TOP - BOTTOM) * (high - value) / (high - low)


def _frame(title: str, axis: str, unit: str, low: float, high: float) -> str:
    lines = [
        f'<text x="{LEFT}" y="16" font-size="13">{escape(title)}</text>',
        f'<text x="{(LEFT + WIDTH) / 2}" y="{HEIGHT - 6}" text-anchor="middle">{escape(axis)}</text>',
    ]
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        value = low + share * (high - low)
        y = _y(value, low, high)
        lines.append(f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>')
        lines.append(
            f'<text x="{LEFT - 4}" y="{y + 4:.1f}" text-anchor="end">{value:.4g} {unit}</text>'
        )
    return "".join(lines)


def _ticks(places: Sequence[str]) -> str:
    return "".join(
        f'<text x="{_x(i, len(places)):.1f}" y="{HEIGHT - 22}" text-anchor="middle">'
        f"{escape(place)}</text>"
        for i, place in enumerate(places)
    )


def _series(
    name: str, spreads: Sequence[Spread], index: int, count: int, low: float, high: float
) -> str:
    colour = COLOURS[index % len(COLOURS)]
    points = [(_x(i, count), found) for i, found in enumerate(spreads) if not isnan(found.mean)]
    path = " ".join(f"{x:.1f},{_y(found.mean, low, high):.1f}" for x, found in points)
    lines = [f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2"/>']
    for x, found in points:
        top, bottom = (_y(found.mean + s * _bar(found), low, high) for s in (1, -1))
        lines.append(f'<path d="M{x:.1f} {top:.1f}V{bottom:.1f}" stroke="{colour}"/>')
        y = _y(found.mean, low, high)
        lines.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>')
    shift = WIDTH - RIGHT - 90 * (index + 1)
    lines.append(f'<text x="{shift}" y="28" fill="{colour}">● {escape(name)}</text>')
    return "".join(lines)
