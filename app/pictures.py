"""The page's pictures of a frames file, without a browser: the map at one order, the curves."""

from typing import TYPE_CHECKING, Any

from app.curve_pictures import TITLES
from app.drawing import Picture, Shape, text
from omnivat.errors import SettingsError

if TYPE_CHECKING:
    import numpy as np

    from omnivat.frames import FrameSet

# the same as in web/shared/palette.js, which a test compares
DOMAINS = ["#e69f00", "#56b4e9", "#009e73", "#d55e00", "#0072b2", "#cc79a7", "#f0e442", "#8c8c8c"]
CLASSES = ["#4477aa", "#ee6677", "#228833", "#ccbb44", "#aa3377", "#66ccee", "#bbbbbb", "#332288"]
MODALITIES = ["#56b4e9", "#e69f00"]
RIGHT_WRONG = ["#009e73", "#d55e00"]
COLOURS = ("domain", "class", "modality", "correctness")
SIDE, EDGE, LINE = 720.0, 14.0, 20.0


def map_picture(
    frames: "FrameSet", *, order: float, stage: str = "f_hat", kind: str = "pca", colour: str
) -> Picture:
    """Return the map of a stage at the stop nearest to `order`, with legend and caption.

    Raises SettingsError for an unknown map or colouring.
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
    title = f"OmniVaT, {TITLES[stage]}, p = {at:.2f}, {kind.upper()}, {what}"
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
    """Return the legend under the map, in as many lines as needed, and its lower end."""
    shapes, x, y = [], EDGE, SIDE + 2 * LINE
    for name, colour in names:
        width = 30 + 7.2 * len(name)
        if x + width > SIDE and x > EDGE:
            x, y = EDGE, y + LINE
        shapes.append(Shape(kind="rect", points=((x, y - 10), (x + 11, y + 1)), fill=colour))
        shapes.append(text((x + 16, y), name))
        x += width
    return shapes, y
