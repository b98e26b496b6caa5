"""The curves of a frames file as a picture, as in Explore, for a paper or a slide."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.drawing import GRID, SOFT, Picture, Shape, text

if TYPE_CHECKING:
    from omnivat.frames import FrameSet

TITLES = {  # of the stages
    "raw": "raw embedding E",
    "frft": "raw DFrFT",
    "relu": "F after ReLU",
    "f_bar": "F after FrATT",
    "f_hat": "F after DTG",
}
CURVES = (
    ("modality_gap", "Modality gap"),
    ("domain_gap", "Domain gap"),
    ("accuracy", "Accuracy, unseen domains"),
    ("margin", "Cosine margin"),
)
ACCENT, MARK, BAND, AREA = "#1d4ed8", "#b91c1c", "#dde5f9", "#c9d7f5"
CLOSE = 0.03  # quarter turns: the same as in web/explore/curves.js, which a test compares
WIDE, HIGH, EDGE = 340.0, 190.0, 14.0
Series = Sequence[float | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Plot:
    """Position and scale of one chart."""

    left: float
    top: float
    start: float
    end: float
    most: float

    def at(self, p: float, value: float) -> tuple[float, float]:
        """Return the position of a value at p, clipped to the axes."""
        x0, x1, y0, y1 = self.box
        share = (p - self.start) / (self.end - self.start or 1)
        level = min(1.0, max(0.0, value / self.most))
        return x0 + share * (x1 - x0), y0 - level * (y0 - y1)

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top of the axes."""
        left, top = self.left, self.top
        return left + 44, left + WIDE - 14, top + HIGH - 34, top + 34


def curves_picture(frames: "FrameSet", *, stage: str = "f_hat", order: float) -> Picture:
    """Return the four curves over p on fixed axes, with `order` and the learned p marked.

    For fixed weights, the pale band shows the orders that the head was trained for. For retrained
    heads, it spans the lowest to the highest training, and dots mark the stops.
    """
    shapes: list[Shape] = []
    for k, (name, title) in enumerate(CURVES):
        plot = Plot(
            left=(k % 2) * WIDE,
            top=(k // 2) * HIGH,
            start=frames.orders[0],
            end=frames.orders[-1],
            most=highest(frames, name),
        )
        shapes += chart(frames, plot, name, title, stage, order)
    note = f"OmniVaT, {TITLES.get(stage, stage)}, {caption(frames)}"
    shapes.append(text((EDGE, 2 * HIGH + 18), note, 11))
    return Picture(width=2 * WIDE, height=2 * HIGH + 30, shapes=tuple(shapes), title=note)


def caption(frames: "FrameSet") -> str:
    """Return a caption for the frames."""
    what = "simulated data" if frames.embeddings.get("simulated") else "real data"
    source = frames.head.get("source")
    parts = [what, *([f"trained on {source}"] if source else [])]
    learned, kind = frames.head.get("learned_order"), frames.head.get("kind", "moved")
    if kind == "retrained":
        parts.append("each stop is a head trained at that p")
    elif kind == "every":
        parts.append("one head trained for every p")
    elif learned is not None:
        parts.append(f"weights are those of the learned p = {learned:.3f}: elsewhere a what-if")
    return "; ".join(parts)


def curve_of(frames: "FrameSet", name: str, stage: str) -> Series | None:
    """Return the values of a measure at a stage; accuracy excludes training pairs."""
    if name != "accuracy":
        return frames.curves.get(f"{name}/{stage}")
    retrained = frames.head.get("kind") == "retrained"
    return frames.curves.get("seeds:accuracy/unseen/mean" if retrained else "accuracy/unseen")


def span_of(frames: "FrameSet", name: str, stage: str) -> tuple[Series, Series] | None:
    """Return the lowest and highest of several trainings, or None for one training."""
    stem = "seeds:accuracy/unseen" if name == "accuracy" else f"seeds:{name}/{stage}"
    low, high = (frames.curves.get(f"{stem}/{end}") for end in ("low", "high"))
    return None if low is None or high is None else (low, high)


def highest(frames: "FrameSet", name: str) -> float:
    """Return the upper limit of a measure over all stages and stops."""
    if name == "accuracy":
        return 1.0
    found = [values for key, values in frames.curves.items() if key.startswith(f"{name}/")]
    return max([0.1, *(v for values in found for v in values if v is not None)])


def chart(
    frames: "FrameSet", plot: Plot, name: str, title: str, stage: str, order: float
) -> list[Shape]:
    """Return one chart; the dashed line is the raw embedding, or chance."""
    own = curve_of(frames, name, stage)
    raw = frames.curves.get(f"{name}/raw")
    level = 1 / len(frames.classes) if name == "accuracy" else (raw[0] if raw else None)
    shapes = [*home(frames, plot), *span(frames, plot, name, stage), *axes(plot, title)]
    if level is not None:
        ends = (plot.at(plot.start, level), plot.at(plot.end, level))
        shapes.append(Shape(kind="line", points=ends, stroke=SOFT, dashed=True))
    known = [(p, v) for p, v in zip(frames.orders, own or (), strict=False) if v is not None]
    if not known:
        return [*shapes, text((plot.box[1], plot.box[3] - 14), "not measured", 12, "end")]
    line = tuple(plot.at(p, v) for p, v in known)
    kind = frames.head.get("kind", "moved")  # fixed weights are grey away from their p
    shapes.append(
        Shape(kind="line", points=line, stroke=SOFT if kind == "moved" else ACCENT, size=2)
    )
    if kind == "retrained":
        shapes += [Shape(kind="circle", points=(place,), fill=ACCENT, size=2.6) for place in line]
    p, v = min(known, key=lambda piece: abs(piece[0] - order))
    words = f"{100 * v:.1f} %" if name == "accuracy" else f"{v:.3f}"
    return [
        *shapes,
        Shape(kind="line", points=(plot.at(p, 0), plot.at(p, plot.most)), stroke=MARK),
        Shape(kind="circle", points=(plot.at(p, v),), fill=MARK, size=4),
        text((plot.box[1], plot.box[3] - 14), f"{words} at p = {p:.3g}", 12, "end"),
    ]


def axes(plot: Plot, title: str) -> list[Shape]:
    """Return title, lines and figures of a chart."""
    x0, x1, y0, y1 = plot.box
    return [
        text((x0, y1 - 14), title, 14),
        Shape(kind="line", points=((x0, y0), (x1, y0)), stroke=GRID),
        Shape(kind="line", points=((x0, y1), (x1, y1)), stroke=GRID),
        text((x0 - 6, y0 + 4), "0", 12, "end"),
        text((x0 - 6, y1 + 4), f"{plot.most:.2f}", 12, "end"),
        text((x0, y0 + 16), f"{plot.start:g}", 12),
        text(((x0 + x1) / 2, y0 + 16), "p", 12, "middle"),
        text((x1, y0 + 16), f"{plot.end:g}", 12, "end"),
    ]


def home(frames: "FrameSet", plot: Plot) -> list[Shape]:
    """Return the band of orders that a head of fixed weights was trained for."""
    learned = frames.head.get("learned_order")
    if frames.head.get("kind", "moved") != "moved" or learned is None:
        return []
    low, high = max(plot.start, learned - CLOSE), min(plot.end, learned + CLOSE)
    if low >= high:
        return []
    corners = (plot.at(low, plot.most), plot.at(high, 0))
    return [Shape(kind="rect", points=corners, fill=BAND)]


def span(frames: "FrameSet", plot: Plot, name: str, stage: str) -> list[Shape]:
    """Return the area between the lowest and the highest of several trainings."""
    ends = span_of(frames, name, stage)
    if ends is None:
        return []
    low, high = (
        [plot.at(p, v) for p, v in zip(frames.orders, end, strict=True) if v is not None]
        for end in ends
    )
    return [Shape(kind="area", points=(*low, *reversed(high)), fill=AREA)]
