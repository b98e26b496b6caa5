"""Several curves of numbers over numbers as one SVG."""

from collections.abc import Mapping, Sequence
from html import escape

WIDTH, HEIGHT = 560, 320
LEFT, RIGHT, TOP, BOTTOM = 52, 96, 34, 44
COLOURS = ("#0b62a4", "#b3480b", "#3d7a1f", "#7a3d9c", "#8a6d00", "#333333")

Curves = Mapping[str, tuple[Sequence[float], Sequence[float]]]


def curve_plot(title: str, across: str, up: str, curves: Curves) -> str:
    """Return an SVG of curves: name -> (places, values)."""
    places = [x for xs, _ in curves.values() for x in xs]
    values = [y for _, ys in curves.values() for y in ys]
    box = (min(places), max(places), 0.0, 1.05 * max(values))
    parts = [_frame(title, across, up, box)]
    for index, (name, (xs, ys)) in enumerate(curves.items()):
        colour = COLOURS[index % len(COLOURS)]
        path = " ".join(
            "{:.1f},{:.1f}".format(*_at(x, y, box)) for x, y in zip(xs, ys, strict=True)
        )
        top = TOP + 14 * index + 8
        parts.append(
            f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>'
        )
        parts.append(
            f'<text x="{WIDTH - RIGHT + 8}" y="{top}" fill="{colour}">{escape(name)}</text>'
        )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'font-family="sans-serif" font-size="11"><title>{escape(title)}</title>'
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>' + "".join(parts) + "</svg>\n"
    )


def _at(x: float, y: float, box: tuple[float, float, float, float]) -> tuple[float, float]:
    left, right, low, high = box
    return (
        LEFT + (WIDTH - LEFT - RIGHT) * (x - left) / (right - left),
        TOP + (HEIGHT - TOP - BOTTOM) * (high - y) / (high - low),
    )


def _frame(title: str, across: str, up: str, box: tuple[float, float, float, float]) -> str:
    left, right, low, high = box
    middle = (LEFT + WIDTH - RIGHT) / 2
    lines = [
        f'<text x="{LEFT}" y="16" font-size="13">{escape(title)}</text>',
        f'<text x="{middle}" y="{HEIGHT - 6}" text-anchor="middle">{escape(across)}</text>',
        f'<text x="12" y="{TOP - 6}">{escape(up)}</text>',
    ]
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        x, y = _at(left + share * (right - left), low + share * (high - low), box)
        lines.append(f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>')
        lines.append(
            f'<text x="{LEFT - 4}" y="{y + 4:.1f}" text-anchor="end">'
            f"{low + share * (high - low):.2g}</text>"
        )
        lines.append(
            f'<text x="{x:.1f}" y="{HEIGHT - 26}" text-anchor="middle">'
            f"{left + share * (right - left):.2g}</text>"
        )
    return "".join(lines)
