"""The relief of a visitor's touch, by the lamps that several touches of its sensor give."""

import json
from io import BytesIO
from typing import TYPE_CHECKING, Any

from app.pair.pictures import Content, decoded, name_in
from app.shared.resources import Resources
from app.shared.state import Question, Reply, one_of
from omnivat.kit.errors import DataError
from omnivat.kit.progress import checkpoint

if TYPE_CHECKING:
    from omnivat.data.relief import Lamps

MOST = 20  # touches of one request: more change the lamps little
KINDS = ("figures", "npy", "ply")


def relief(resources: Resources, content: Content, question: Question) -> bytes | Reply:
    """Return the relief of the first of several touches of one sensor, which give its lamps.

    content   the touches, one after the other
    question  {"sizes": bytes of each, with commas; "as": "figures", to draw;
              "npy", slopes to the right and downwards and heights (H, W, 3) float32; or "ply", the
              heights as a surface}

    Raises DataError for sizes that are not those of the content, and where touches give no lamps.
    """
    import numpy as np

    from omnivat.data.dots import fill_dots
    from omnivat.data.relief import heights, lamps, ply, slopes

    kind = one_of("as", question.get("as"), KINDS)
    touches = []
    for part in parts(content, str(question.get("sizes", "")), MOST):
        image = decoded(resources, part, question)
        touches.append(fill_dots(np.asarray(image))[0])
        checkpoint()
    gel = lamps(touches, dots="keep")
    checkpoint()
    high, steep = (of(touches[0], gel, dots="keep") for of in (heights, slopes))
    if kind == "ply":
        return ply(high)
    if kind == "npy":
        with BytesIO() as file:
            np.save(file, np.concatenate([steep, high[..., None]], -1))
            return file.getvalue()
    return drawn(name_in(question), high, steep, gel, str(question.get("theme")))


def drawn(name: str, heights: Any, slopes: Any, gel: "Lamps", theme: str) -> Reply:
    """Return heights (H, W) to turn, and slopes (H, W, 2), as Plotly's figures, and a caption."""
    from omnivat import figures

    shown = (
        figures.relief(heights, title=f"Heights of {name}"),
        figures.slopes(slopes, title="Slopes, red where the gel rises"),
    )
    bare = {"title": "", "showticklabels": False}
    near = {"x": 0.3, "y": -1.1, "z": 0.9}  # from the picture's lower edge
    shown[0].update_scenes(xaxis=bare, yaxis=bare, zaxis=bare, camera={"eye": near})
    shown[0].update_layout(height=360, margin={"l": 0, "r": 0, "t": 40, "b": 0})
    caption = (
        f"Lamps from {gel.pictures} touches, in 95 % of draws within cosine {gel.confidence:.2f}."
        " Heights have no unit, and the sign may be wrong."
    )
    template = "omnivat_dark" if theme == "dark" else "omnivat"
    plots = [json.loads(one.update_layout(template=template).to_json()) for one in shown]
    return {"figures": plots, "caption": caption}


def parts(content: Content, sizes: str, most: int) -> list[bytes]:
    """Return the pictures in a body; raises DataError if they are not all of it, or more than
    `most`."""
    whole = content if isinstance(content, bytes) else content.read_bytes()
    numbers = [int(one) if one.isdecimal() else 0 for one in sizes[: 9 * most].split(",")]
    if len(numbers) > most or not all(numbers) or sum(numbers) != len(whole):
        raise DataError(
            f"sizes is '{sizes:.40}' for {len(whole):,} bytes; give the bytes of each of 1 to"
            f" {most} touches, with commas."
        )
    ends = [sum(numbers[: k + 1]) for k in range(len(numbers))]
    return [whole[end - size : end] for end, size in zip(ends, numbers, strict=True)]
