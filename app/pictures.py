"""The page's pictures of a frames file, without a browser: the map at one order, the curves."""

from typing import TYPE_CHECKING, Any

from app.drawing import Picture, Shape
from omnivat.errors import SettingsError

if TYPE_CHECKING:
    import numpy as np

    from omnivat.frames import FrameSet

# the same as in web/palette.js, which a test compares
DOMAINS = ["#e69f00", "#56b4e9", "#009e73", "#d55e00", "#0072b2", "#cc79a7", "#f0e442", "#8c8c8c"]
CLASSES = ["#4477aa", "#ee6677", "#228833", "#ccbb44", "#aa3377", "#66ccee", "#bbbbbb", "#332288"]
MODALITIES = ["#56b4e9", "#e69f00"]
RIGHT_WRONG = ["#009e73", "#d55e00"]
COLOURS = ("domain", "class", "modality", "correctness")
STAGES = {
    "raw": "raw embedding E",
    "frft": "raw DFrFT",
    "relu": "F after ReLU",
    "f_bar": "F after FrATT",
    "f_hat": "F after DTG",
}
INK, SOFT, GRID = "#0f172a", "#55637a", "#dbe2ea"
SIDE, EDGE, LINE = 720.0, 14.0, 20.0
CURVES = (
    ("modality_gap", "Modality gap"),
    ("domain_gap", "Domain gap"),
    ("accuracy", "Accuracy"),
    ("margin", "Cosine margin"),
)


def map_picture(
    frames: "FrameSet", *, order: float, stage: str = "f_hat", kind: str = "pca", colour: str
) -> Picture:
    """Return the map of a stage at the stop nearest to `order`, with legend and caption.

    Raises SettingsError for a map or colouring that is not there.
    """
    drawn = frames.maps.get(f"{kind}/{stage}")
    if drawn is None:
        there = ", ".join(frames.maps)
        raise SettingsError(f"There is no map '{kind}/{stage}' in these frames; there are {there}.")
    frame = min(range(len(drawn.orders)), key=lambda i: abs(frames.orders[drawn.orders[i]] - order))
    stop = min(range(len(frames.orders)), key=lambda i: abs(frames.orders[i] - order))
    low, high = drawn.low, drawn.high
    scale = (SIDE - 2 * EDGE) / (high[0] - low[0])
    names, group = grouped(frames, colour, stop)
    shapes = []
    for i, (x, y) in enumerate(drawn.places(frame)):
        vis = i < frames.pairs
        place = (EDGE + (x - low[0]) * scale, SIDE - EDGE - (y - low[1]) * scale)
        shapes.append(
            Shape(
                kind="circle" if vis else "triangle",
                points=(place,),
                fill=names[group[i]][1],
                size=2.8,
                opacity=0.85,
            )
        )
    at = frames.orders[stop] if len(drawn.orders) == 1 else frames.orders[drawn.orders[frame]]
    what = "simulated data" if frames.embeddings.get("simulated") else "real data"
    title = f"OmniVaT, {STAGES[stage]}, p = {at:.2f}, {kind.upper()}, {what}"
    legend, bottom = legend_of(names)
    return Picture(
        width=SIDE,
        height=bottom + 8,
        shapes=(*shapes, text((EDGE, SIDE + LINE), title + "; circle VIS, triangle TAC"), *legend),
        title=title,
    )


def grouped(
    frames: "FrameSet", colour: str, stop: int
) -> "tuple[list[tuple[str, str]], np.ndarray[Any, Any]]":
    """Return the groups' names and colours, and the group of each of the 2N points."""
    import numpy as np

    if colour == "domain":
        names, of = list(frames.domains), frames.domain
        palette = DOMAINS
    elif colour == "class":
        names, of = list(frames.classes), frames.label
        palette = CLASSES
    elif colour == "correctness":
        names, of = ["right", "wrong"], (frames.prediction[stop] != frames.label).astype(np.uint8)
        palette = RIGHT_WRONG
    elif colour == "modality":
        both = np.repeat(np.arange(2, dtype=np.uint8), frames.pairs)
        return list(zip(["VIS", "TAC"], MODALITIES, strict=True)), both
    else:
        raise SettingsError(f"--colour is '{colour}'; choose one of {', '.join(COLOURS)}.")
    coloured = [(name, palette[i % len(palette)]) for i, name in enumerate(names)]
    return coloured, np.concatenate([of, of])


def legend_of(names: list[tuple[str, str]]) -> tuple[list[Shape], float]:
    """Return the legend under the map, in as many lines as it needs, and where it ends."""
    shapes, x, y = [], EDGE, SIDE + 2 * LINE
    for name, colour in names:
        width = 30 + 7.2 * len(name)
        if x + width > SIDE and x > EDGE:
            x, y = EDGE, y + LINE
        shapes.append(Shape(kind="rect", points=((x, y - 10), (x + 11, y + 1)), fill=colour))
        shapes.append(text((x + 16, y), name))
        x += width
    return shapes, y


def curves_picture(frames: "FrameSet", *, stage: str = "f_hat", order: float) -> Picture:
    """Return the four curves over p on fixed axes, with `order` and the learned p marked."""
    wide, high = 340.0, 190.0
    shapes: list[Shape] = []
    for k, (name, title) in enumerate(CURVES):
        left, top = (k % 2) * wide, (k // 2) * high
        shapes += chart(frames, name, title, stage, order, left, top, wide, high)
    learned = frames.head.get("learned_order")
    what = "simulated data" if frames.embeddings.get("simulated") else "real data"
    note = f"OmniVaT, {STAGES.get(stage, stage)}, {what}"
    if learned is not None:
        note += f"; learned p = {learned:.3f}, weights are those of that p: elsewhere a what-if"
    shapes.append(text((EDGE, 2 * high + 18), note, 11))
    return Picture(width=2 * wide, height=2 * high + 30, shapes=tuple(shapes), title=note)


def chart(
    frames: "FrameSet",
    name: str,
    title: str,
    stage: str,
    order: float,
    left: float,
    top: float,
    wide: float,
    high: float,
) -> list[Shape]:
    """Return one chart; the dashed line is the raw embedding's, or guessing."""
    x0, x1, y0, y1 = left + 44, left + wide - 14, top + high - 34, top + 34
    start, end = frames.orders[0], frames.orders[-1]
    answers = name == "accuracy"
    own = frames.curves.get("accuracy/all" if answers else f"{name}/{stage}")
    raw = frames.curves.get(f"{name}/raw")
    known = [
        v
        for key, values in frames.curves.items()
        if key.startswith(f"{name}/")
        for v in values
        if v is not None
    ]
    most = 1.0 if answers else max([0.1, *known])

    def at(p: float, v: float) -> tuple[float, float]:
        share = (p - start) / (end - start or 1)
        return x0 + share * (x1 - x0), y0 - v / most * (y0 - y1)

    shapes = [
        text((x0, y1 - 14), title, 14),
        Shape(kind="line", points=((x0, y0), (x1, y0)), stroke=GRID),
        Shape(kind="line", points=((x0, y1), (x1, y1)), stroke=GRID),
        text((x0 - 6, y0 + 4), "0", 11, "end"),
        text((x0 - 6, y1 + 4), f"{most:.2f}", 11, "end"),
        text((x0, y0 + 16), f"{start:g}", 11),
        text(((x0 + x1) / 2, y0 + 16), "p", 11, "middle"),
        text((x1, y0 + 16), f"{end:g}", 11, "end"),
    ]
    level = 1 / len(frames.classes) if answers else (raw[0] if raw else None)
    if level is not None:
        ends = (at(start, level), at(end, level))
        shapes.append(Shape(kind="line", points=ends, stroke=SOFT, dashed=True))
    pieces = [(p, v) for p, v in zip(frames.orders, own or (), strict=False) if v is not None]
    if pieces:
        line = tuple(at(p, v) for p, v in pieces)
        shapes.append(Shape(kind="line", points=line, stroke="#1d4ed8", size=2))
        p, v = min(pieces, key=lambda piece: abs(piece[0] - order))
        shapes.append(Shape(kind="line", points=(at(p, 0), at(p, most)), stroke="#b91c1c"))
        shapes.append(Shape(kind="circle", points=(at(p, v),), fill="#b91c1c", size=4))
        shapes.append(text((x1, y1 - 14), f"{v:.3f} at p = {p:.2f}", 12, "end"))
    return shapes


def text(point: tuple[float, float], words: str, size: float = 12, anchor: str = "start") -> Shape:
    """Return a text in the ink of the page."""
    return Shape(kind="text", points=(point,), text=words, size=size, anchor=anchor, fill=INK)
