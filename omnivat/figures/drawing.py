"""Pictures of simple shapes, as SVG or PNG, without a browser or a plotting library."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from PIL import Image, ImageColor, ImageDraw, ImageFont

Point = tuple[float, float]
INK, SOFT, GRID = "#0f172a", "#55637a", "#dbe2ea"
UNWRITABLE = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # in XML
SCALE = 2  # pixels of a PNG for one unit
FINE = 2  # a PNG is drawn this much larger and scaled down, for smooth edges


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """One shape of one colour; all but lines are filled.

    kind    "circle" (one point and `size`), "line" (points), "area" (corners), "rect" (two
            corners) or "text" (one point and `text`)
    anchor  of a text: "start", "middle" or "end"
    """

    kind: str
    points: tuple[Point, ...]
    colour: str
    size: float = 1.0
    opacity: float = 1.0
    text: str = ""
    anchor: str = "start"
    dashed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """Shapes on a white background, later ones on top."""

    width: float
    height: float
    shapes: tuple[Shape, ...]
    title: str


def text(
    point: Point, words: str, size: float = 12, anchor: str = "start", colour: str = INK
) -> Shape:
    """Return a text, in the ink of the page unless stated."""
    return Shape(kind="text", points=(point,), text=words, size=size, anchor=anchor, colour=colour)


def svg(picture: Picture) -> str:
    """Return the picture as SVG text."""
    body = "\n".join(_element(shape) for shape in picture.shapes)
    size = f'width="{picture.width:g}" height="{picture.height:g}"'
    view = f'viewBox="0 0 {picture.width:g} {picture.height:g}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} {view} font-family="sans-serif"'
        f' role="img"><title>{_xml(picture.title)}</title><rect width="100%" height="100%"'
        f' fill="#fff"/>\n{body}\n</svg>\n'
    )


def _xml(words: str) -> str:
    return escape(UNWRITABLE.sub("\ufffd", words))


def _element(shape: Shape) -> str:
    """Return a shape as an SVG element."""
    paint = f'fill="{shape.colour}"'
    if shape.opacity < 1:
        paint += f' opacity="{shape.opacity:g}"'
    (x, y), *rest = shape.points
    if shape.kind == "circle":
        return f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{shape.size:g}" {paint}/>'
    if shape.kind == "rect":
        right, bottom = rest[0]
        return f'<rect x="{x:g}" y="{y:g}" width="{right - x:g}" height="{bottom - y:g}" {paint}/>'
    if shape.kind == "text":
        look = f'font-size="{shape.size:g}" text-anchor="{shape.anchor}"'
        return f'<text x="{x:g}" y="{y:g}" {look} {paint}>{_xml(shape.text)}</text>'
    points = " ".join(f"{a:.2f},{b:.2f}" for a, b in shape.points)
    if shape.kind == "area":
        return f'<polygon points="{points}" {paint}/>'
    dashes = ' stroke-dasharray="4 3"' if shape.dashed else ""
    paint = f'fill="none" stroke="{shape.colour}"'
    return f'<polyline points="{points}" {paint} stroke-width="{shape.size:g}"{dashes}/>'


def png(picture: Picture) -> Any:
    """Return the picture as a Pillow image, SCALE pixels for one unit."""
    factor = SCALE * FINE
    size = round(picture.width * factor), round(picture.height * factor)
    image = Image.new("RGB", size, "#ffffff")
    draw = ImageDraw.Draw(image, "RGBA")
    for shape in picture.shapes:
        _paint(draw, shape, factor)
    return image.resize((size[0] // FINE, size[1] // FINE), Image.Resampling.LANCZOS)


def _paint(draw: Any, shape: Shape, factor: float) -> None:
    """Paint a shape on an image of `factor` pixels for one unit."""
    fill = (*ImageColor.getrgb(shape.colour), round(255 * shape.opacity))
    points = [(x * factor, y * factor) for x, y in shape.points]
    size = shape.size * factor
    if shape.kind == "circle":
        x, y = points[0]
        box = (x - size, y - size, x + size, y + size)
        draw.ellipse(box, fill=fill)
    elif shape.kind == "area":
        draw.polygon(points, fill=fill)
    elif shape.kind == "rect":
        draw.rectangle((*points[0], *points[1]), fill=fill)
    elif shape.kind == "text":
        anchor = {"start": "ls", "middle": "ms", "end": "rs"}[shape.anchor]
        font = ImageFont.load_default(size)
        draw.text(points[0], shape.text, fill=fill, font=font, anchor=anchor)
    elif shape.dashed:
        for a, b in _dashes(points, 5 * factor):
            draw.line((a, b), fill=fill, width=round(size))
    else:
        draw.line(points, fill=fill, width=round(size), joint="curve")


def _dashes(points: Sequence[Point], length: float) -> Iterable[tuple[Point, Point]]:
    """Yield the dashes of a straight line from the first point to the last."""
    (x0, y0), (x1, y1) = points[0], points[-1]
    span = max(((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5, 1e-9)
    for k in range(int(span / length / 2) + 1):
        a, b = (min(1.0, (2 * k + end) * length / span) for end in (0, 1))
        yield (x0 + a * (x1 - x0), y0 + a * (y1 - y0)), (x0 + b * (x1 - x0), y0 + b * (y1 - y0))
