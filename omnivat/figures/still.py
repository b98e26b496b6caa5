"""A figure in two dimensions as shapes, for SVG and PNG without a browser.

It draws what the figures of this folder use: scatter and heatmap traces, error bars, areas, lines
and rectangles on axes, titles, ticks, legend and caption.
"""

import math
import re
from collections.abc import Iterator, Sequence
from html import unescape
from itertools import pairwise
from textwrap import wrap
from typing import Any, NamedTuple

from omnivat.figures.drawing import GRID, INK, Picture, Point, Shape, svg, text
from omnivat.figures.theme import MARGIN, THEMES
from omnivat.kit.errors import SettingsError

WIDTH, LINE, LETTER = 760.0, 17.0, 6.6


class Plane(NamedTuple):
    """One pair of axes: the ranges, and the pixels of left, right, bottom and top."""

    x: tuple[float, float]
    y: tuple[float, float]
    box: tuple[float, float, float, float]

    def at(self, x: float, y: float) -> Point:
        """Return the pixel of a value, clipped to the axes."""
        left, right, low, high = self.box
        across = (x - self.x[0]) / (self.x[1] - self.x[0] or 1)  # frames may have one order
        up = (y - self.y[0]) / (self.y[1] - self.y[0])
        return (
            left + min(1.0, max(0.0, across)) * (right - left),
            low - min(1.0, max(0.0, up)) * (low - high),
        )


def picture(figure: Any) -> Picture:
    """Return a figure as shapes in the light theme.

    Raises SettingsError for a trace that has no flat picture, such as a map in three dimensions.
    """
    for trace in figure.data:
        if trace.type not in ("scatter", "scattergl", "heatmap"):
            raise SettingsError(
                f"A figure of the kind '{trace.type}' has no SVG or PNG; name a file that ends in"
                " .html."
            )
    height = float(figure.layout.height)
    # "", "2", ...
    keys = [name[5:] for name in figure.layout.to_plotly_json() if name.startswith("xaxis")]
    planes = {key: _plane(figure, key, height) for key in keys}
    shapes = [shape for key, plane in planes.items() for shape in _axes(figure, key, plane)]
    shapes += [s for shape in figure.layout.shapes for s in _marked(shape, planes)]
    for trace in figure.data:
        plane = planes[(trace.xaxis or "x")[1:]]
        shapes += _heat(trace, plane) if trace.type == "heatmap" else _scatter(trace, plane)
    shapes += [s for note in figure.layout.annotations for s in _note(note, planes)]
    title = unescape(figure.layout.title.text)
    shapes.append(text((12, 22), title, 15))
    lowest = max(shape.points[0][1] for shape in shapes if shape.text)  # names in several rows
    below, bottom = _below(figure, max(height, lowest + 16))
    return Picture(width=WIDTH, height=bottom, shapes=(*shapes, *below), title=title)


def svg_of(figure: Any) -> str:
    """Return a figure as SVG text; raises as `picture`."""
    return svg(picture(figure))


def _plane(figure: Any, key: str, height: float) -> Plane:
    across, up = figure.layout[f"xaxis{key}"], figure.layout[f"yaxis{key}"]
    margin = {side: getattr(figure.layout.margin, side) or size for side, size in MARGIN.items()}
    inner = WIDTH - margin["l"] - margin["r"], height - margin["t"] - margin["b"]
    left, right = (margin["l"] + share * inner[0] for share in across.domain or (0, 1))
    low, high = (margin["t"] + (1 - share) * inner[1] for share in up.domain or (0, 1))
    box = (left, right, low, high)
    x, y = (tuple(map(float, axis.range)) for axis in (across, up))
    if up.scaleanchor:  # one unit is as long in both directions
        unit = min((right - left) / (x[1] - x[0]), (low - high) / (y[1] - y[0]))
        box = (left, left + unit * (x[1] - x[0]), high + unit * (y[1] - y[0]), high)
    return Plane(x, y, box)  # type: ignore[arg-type]


def _axes(figure: Any, key: str, plane: Plane) -> Iterator[Shape]:
    """Yield ticks, grid and titles of both axes."""
    across, up = figure.layout[f"xaxis{key}"], figure.layout[f"yaxis{key}"]
    left, right, low, high = plane.box
    if across.visible is not False:
        ticks = _ticks(across, plane.x)
        wide = LETTER * len(max((label for _, label in ticks), key=len, default=""))
        # long names take turns
        rows = min(4, max(1, math.ceil(wide * len(ticks) / (right - left))))
        for k, (value, label) in enumerate(ticks):
            x = min(plane.at(value, min(plane.y))[0], WIDTH - LETTER * len(label) / 2)
            yield text((x, low + 16 + 13 * (k % rows)), label, 11, "middle")
        yield text(
            ((left + right) / 2, low + 23 + 13 * rows), unescape(across.title.text), 12, "middle"
        )
    if up.visible is not False:
        for value, label in _ticks(up, plane.y):
            start, end = (plane.at(x, value) for x in plane.x)
            if up.showgrid is not False:
                yield Shape(kind="line", points=(start, end), colour=GRID)
            yield text((left - 6, start[1] + 4), label, 11, "end")
        yield text((max(12, left - 46), high - 8), unescape(up.title.text), 11)


def _ticks(axis: Any, ends: Sequence[float]) -> list[tuple[float, str]]:
    """Return value and label of each tick: the axis's own, or about five round values."""
    if axis.tickvals is not None:
        words = map(unescape, axis.ticktext)
        return [(float(v), w) for v, w in zip(axis.tickvals, words, strict=True)]
    if axis.showticklabels is False:
        return []
    low, high = min(ends), max(ends)
    rough = (high - low or 1) / 5
    size = 10.0 ** math.floor(math.log10(rough))
    step = next(size * k for k in (1, 2, 5, 10) if size * k >= rough * 0.95)
    first = math.ceil(low / step - 1e-9)
    values = [k * step for k in range(first, first + 8) if k * step <= high + 1e-9 * step]
    return [
        (v, f"{100 * v:.0f} %" if "%" in (axis.tickformat or "") else f"{v:.6g}") for v in values
    ]


def _scatter(trace: Any, plane: Plane) -> Iterator[Shape]:
    """Yield area, lines, error bars and markers of a trace; lines break at missing values."""
    known = [
        (k, float(x), float(y))
        for k, (x, y) in enumerate(zip(trace.x, trace.y, strict=True))
        if y is not None and math.isfinite(y)
    ]
    points = [plane.at(x, y) for _, x, y in known]
    if trace.fill == "toself" and points:
        yield Shape(kind="area", points=tuple(points), **_translucent(trace.fillcolor))
    if "lines" in trace.mode and trace.line.width != 0:
        size, stroke = trace.line.width or 2, trace.line.color
        gaps = [i for i in range(1, len(known)) if known[i][0] > known[i - 1][0] + 1]
        for first, last in pairwise([0, *gaps, len(known)]):
            if last - first > 1:
                part = tuple(points[first:last])
                yield Shape(kind="line", points=part, colour=stroke, size=size)
    ink = trace.marker.color
    for (across, up), error in (((1, 0), trace.error_x), ((0, 1), trace.error_y)):
        high = error.array if error.array is not None else ()
        low = high if error.arrayminus is None else error.arrayminus
        for k, x, y in known if len(high) else []:
            ends = [(x + across * by, y + up * by) for by in (-low[k], high[k])]
            if all(math.isfinite(v) for end in ends for v in end):
                bar = tuple(plane.at(*end) for end in ends)
                yield Shape(kind="line", points=bar, colour=ink, size=1.6)
    if "markers" in trace.mode:
        size, share = trace.marker.size / 2, trace.marker.opacity or 1
        triangle = trace.marker.symbol == "triangle-up"  # looks as large as a circle
        for x, y in points:
            left, right, low = x - 1.25 * size, x + 1.25 * size, y + size
            corners = ((x, y - 1.25 * size), (right, low), (left, low))
            kind, place = ("area", corners) if triangle else ("circle", ((x, y),))
            yield Shape(kind=kind, points=place, colour=ink, size=size, opacity=share)


def _heat(trace: Any, plane: Plane) -> Iterator[Shape]:
    full = THEMES["omnivat"]["full"]
    for row, values in enumerate(trace.z):
        for column, value in enumerate(values):
            if value is None or not math.isfinite(value):
                continue
            share = max(0.0, float(value) / trace.zmax)
            corners = [plane.at(column + by, row + by) for by in (-0.5, 0.5)]
            rect = _rect(corners, full, share)
            yield rect
            (x0, y0), (x1, y1) = rect.points
            middle, ink = ((x0 + x1) / 2, (y0 + y1) / 2 + 4), "#ffffff" if share > 0.6 else INK
            yield text(middle, str(trace.text[row][column]), 11, "middle", ink)


def _rect(ends: Sequence[Point], colour: str, opacity: float) -> Shape:
    (x0, y0), (x1, y1) = ends
    corners = (x0, min(y0, y1)), (x1, max(y0, y1))
    return Shape(kind="rect", points=corners, colour=colour, opacity=opacity)


def _marked(mark: Any, planes: dict[str, Plane]) -> Iterator[Shape]:
    """Draw a line or rectangle of the layout; "domain" spans an axis."""
    plane = planes[(mark.xref or "x").split()[0][1:]]
    (left, right), (low, high) = (
        ends if "domain" in (name or "") else (0.0, 1.0)
        for ends, name in ((plane.x, mark.xref), (plane.y, mark.yref))
    )
    ends = [
        plane.at(left + x * (right - left), low + y * (high - low))
        for x, y in ((mark.x0, mark.y0), (mark.x1, mark.y1))
    ]
    if mark.type == "line":
        stroke, dashed = mark.line.color, mark.line.dash is not None
        yield Shape(kind="line", points=tuple(ends), colour=stroke, dashed=dashed, size=1.4)
    else:
        yield _rect(ends, **_translucent(mark.fillcolor))


def _note(note: Any, planes: dict[str, Plane]) -> Iterator[Shape]:
    """Draw a text placed in shares of its axes, upwards from its last line."""
    left, right, low, high = planes[note.xref.split()[0][1:]].box
    x, y = left + note.x * (right - left), low - note.y * (low - high) - 6
    rows = [unescape(row) for row in note.text.split("<br>")]
    for k, row in enumerate(rows):
        yield text((x, y - 15 * (len(rows) - 1 - k)), row)


def _below(figure: Any, height: float) -> tuple[list[Shape], float]:
    """Return legend and caption under the axes, and the lower end of the picture."""
    shapes, x, y = [], 14.0, height
    named = [t for t in figure.data if t.name and t.showlegend is not False]
    for trace in named if figure.layout.showlegend is not False else []:
        name, colour = unescape(trace.name), trace.marker.color or trace.line.color
        size = 34 + LETTER * len(name)
        if x + size > WIDTH and x > 14:
            x, y = 14.0, y + LINE
        shapes.append(Shape(kind="rect", points=((x, y - 10), (x + 11, y + 1)), colour=colour))
        shapes.append(text((x + 16, y), name))
        x += size
    y += 8 if named else 0
    for line in wrap(figure.layout.meta["caption"], int(WIDTH / (LETTER - 0.7))):
        y += LINE
        shapes.append(text((14, y), line, 11))
    return shapes, y + 14


def _translucent(colour: str) -> dict[str, Any]:
    """Return "rgba(r,g,b,a)" as a fill and its opacity."""
    *parts, share = re.findall(r"[\d.]+", colour)
    return {"colour": "#" + "".join(f"{int(part):02x}" for part in parts), "opacity": float(share)}
