"""Replies to a request whose body is a picture: its name for later, a live prediction, or
occlusion.
"""

import base64
from io import BytesIO
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from app.shared.familiar import predict_one
from app.shared.mend import mend_in, mended
from app.shared.pair_input import OTHER, pair_request, rounded
from app.shared.resources import Resources
from app.shared.state import Question, Reply, one_of
from omnivat.kit.errors import DataError
from omnivat.kit.progress import checkpoint

if TYPE_CHECKING:
    from PIL.Image import Image
    from torch import Tensor

Content = bytes | Path  # a picture, or its file
BOTH = "both"
PREVIEW_SIDE = 320  # pixels of the preview
CELLS = 7  # of occlusion, for each side of the picture shown
PATCH = 2  # side of the hidden square, in cells; a single cell changes little
STEPS = CELLS - PATCH + 1  # places of the square, along each side
AT_ONCE = 8  # images embedded between two checks for a cancelled request
SIDE = 448  # pixels; the image is first scaled down to this, encoders use 224


def taken(resources: Resources, content: Content, question: Question) -> Reply:
    """Embed an image; return its name and a small preview. The picture itself is not kept."""
    ref, found = resources.take_image(content, name_in(question), mend_in(question))
    return {
        "ref": str(ref),
        "width": found.width,
        "height": found.height,
        "preview": preview(found.image),
    }


def name_in(question: Question) -> str:
    """Return the name of a request's picture."""
    return str(question.get("name", ""))[:120] or "the image"


def decoded(
    resources: Resources, content: Content, question: Question, modality: str = "tac"
) -> "Image":
    """Return the picture in a request, decoded in a limited process; a touch is mended."""
    image = resources.shared.decoder.read(content, name_in(question)).image
    return mended(image, mend_in(question)) if modality == "tac" else image


def preview(image: "Image") -> str:
    """Return a small JPEG of the image, upright, as a data URL."""
    small = image.reduce(max(1, max(image.size) // PREVIEW_SIDE))  # a fifth of the time
    small.thumbnail((PREVIEW_SIDE, PREVIEW_SIDE))
    with BytesIO() as handle:
        small.save(handle, "JPEG", quality=85)
        return "data:image/jpeg;base64," + base64.b64encode(handle.getvalue()).decode()


def live(resources: Resources, content: Content, question: Question) -> Reply:
    """Predict one picture, or a photo and a touch.

    question  {"modality": "vis", "tac" or "both"; "split": bytes of the photo before those of the
              touch, for both}; and see `pair_request`
    return    classes, probabilities of each reading, `images`: modality -> whether the prediction
              is a `guess`, and milliseconds of encoder and head

    Raises DataError if the picture cannot be read or its modality is unknown.
    """
    import torch

    from omnivat.encoders.base import for_modality

    encoders = {one: for_modality(resources.encoder(), one) for one in OTHER}
    with torch.inference_mode():
        pixels = {
            one: encoders[one].preprocess(decoded(resources, part, question, one))
            for one, part in _parts(content, question).items()
        }
        began = perf_counter()
        rows = {one: encoders[one].embed(some[None]) for one, some in pixels.items()}
        embedded = perf_counter()
    named = pair_request(resources, question, rows)
    found = predict_one(named)
    ms = {"encoder": embedded - began, "head": perf_counter() - embedded}
    ms = {part: round(1000 * seconds, 1) for part, seconds in ms.items()}
    return {"classes": list(named.head.settings.classes), **found, "ms": ms}


def _parts(content: Content, question: Question) -> dict[str, Content]:
    """Return modality -> content of each picture in a request."""
    modality = one_of("modality", question.get("modality"), (*OTHER, BOTH))
    split = str(question.get("split", ""))[:9]
    if modality != BOTH:
        return {modality: content}
    whole = content.read_bytes() if isinstance(content, Path) else content
    end = int(split) if split.isdecimal() else 0
    if not 0 < end < len(whole):
        raise DataError(f"split is {end}; give the bytes of the photo, before those of the touch.")
    return {"vis": whole[:end], "tac": whole[end:]}


def occlusion(resources: Resources, content: Content, question: Question) -> Reply:
    """Hide each part of an image in turn, predict again, and measure the change of the probability.

    question  {"modality": "vis" or "tac", "other": reference of the other image}; and see
              `pair_request`
    return    the predicted class, its probability, and `drops` (CELLS, CELLS): the decrease of the
              probability when a part is hidden; negative for an increase

    Raises DataError if the image cannot be read or its modality is not "vis" or "tac".
    """
    import numpy as np
    import torch
    from PIL.Image import fromarray

    from omnivat.encoders.base import for_modality

    modality = one_of("modality", question.get("modality"), OTHER)
    image = decoded(resources, content, question, modality)
    image.thumbnail((SIDE, SIDE))
    whole, mean = (torch.from_numpy(np.array(one)) for one in (image, image.resize((1, 1))))
    shown = [image, *(fromarray(part.numpy()) for part in hidden(whole[None], mean))]
    encoder = for_modality(resources.encoder(), modality)
    with torch.inference_mode():
        pixels = [encoder.preprocess(one) for one in shown]
        parts = []
        for few in torch.stack(pixels).split(AT_ONCE):
            checkpoint()
            parts.append(encoder.embed(few))
    beside = {**question, OTHER[modality]: question.get("other")}
    named = pair_request(resources, beside, {modality: torch.cat(parts)})
    with torch.inference_mode():
        out = named.head.model(named.pair["vis"], named.pair["tac"], order=named.order)
        predicted = int(out.probabilities[0].argmax())
        falls = out.probabilities[0, predicted] - out.probabilities[1:, predicted]
    return {
        "class": named.head.settings.classes[predicted],
        "probability": round(float(out.probabilities[0, predicted]), 6),
        "drops": rounded(over_cells(falls).numpy()),
    }


def hidden(picture: "Tensor", colour: "Tensor") -> "Tensor":
    """Return a picture (1, H, W, 3) with one part after the other in one colour (3,), row by row:
    (STEPS², H, W, 3).
    """
    import torch

    def along(side: int) -> "Tensor":
        """Return which pixels of a side each part covers, (STEPS, side)."""
        edges, at = torch.arange(CELLS + 1)[:, None] * side // CELLS, torch.arange(side)
        return (at >= edges[:-PATCH]) & (at < edges[PATCH:])

    down, across = (along(side) for side in picture.shape[1:3])
    parts = (down[:, None, :, None] & across[:, None]).flatten(0, 1)
    return torch.where(parts[..., None], colour, picture)


def over_cells(falls: "Tensor") -> "Tensor":
    """Return the mean decrease (CELLS, CELLS) of each cell, over the parts (STEPS²,) that cover
    it.
    """
    import torch
    from torch.nn.functional import conv_transpose2d

    part = torch.ones(1, 1, PATCH, PATCH)
    rows = torch.stack((falls, torch.ones_like(falls))).unflatten(1, (1, STEPS, STEPS))
    sums, counts = conv_transpose2d(rows, part)[:, 0]
    means: Tensor = sums / counts
    return means
