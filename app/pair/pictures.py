"""Pictures that come with a request: read once, and sent back as their embeddings; and a live
prediction, and occlusion.
"""

import base64
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from app.shared.familiar import predict_one
from app.shared.mend import mend_in, mended
from app.shared.pair_input import OTHER, lamps_in, pair_request, rounded
from app.shared.requests import FILES
from app.shared.resources import Resources
from app.shared.state import InTwo, Question, Reply, Unread, one_of
from omnivat.kit.errors import DataError
from omnivat.kit.progress import checkpoint
from omnivat.kit.stages import IMAGES

if TYPE_CHECKING:
    from PIL.Image import Image
    from torch import Tensor

Content = bytes | Path  # a picture, or its file
IMAGE_KEYS = ("vis", "tac", "photos", "touches")  # of a question, of its pairs and lessons
BOTH = "both"
PREVIEW_SIDE = 320  # pixels of the preview
CELLS = 7  # of occlusion, for each side of the picture shown
PATCH = 2  # side of the hidden square, in cells; a single cell changes little
STEPS = CELLS - PATCH + 1  # places of the square, along each side
AT_ONCE = 8  # images embedded between two checks for a cancelled request
SIDE = 448  # pixels; the image is first scaled down to this, encoders use 224


def taken(resources: Resources, content: Content, question: Question) -> Reply:
    """Read an image; return its embeddings, for later requests, its size and a small preview.
    Nothing of it is kept.
    """
    lamps = lamps_in(resources, question)
    ref, found = resources.take_image(content, name_in(question), mend_in(question), lamps)
    return {
        "ref": str(ref),
        "width": found.width,
        "height": found.height,
        "preview": preview(found.image),
    }


def with_pictures(work: Callable[..., Any], resources: Resources, question: Question) -> Any:
    """Do some work on a question whose "file:0", … are the pictures that came with it.

    question  "names": what each is called in a sentence
    return    the reply, and `pictures`: of each, as `taken` has it, or the `problem` of one that
              cannot be read; null for one that the question does not name; where such a problem
              leaves no reply, only them and `problem`
    """
    files, names = question.get(FILES, []), question.get("names")
    if not files:
        return work(resources, question)
    read: list[Reply | None] = [None] * len(files)

    def embedded(value: Any) -> Any:
        """Return an image of the question, one that came as a file by its embeddings."""
        number = value.removeprefix("file:") if isinstance(value, str) else ""
        at = int(number) if number.isdecimal() and len(number) < 4 else len(files)
        if number == value or at >= len(files):
            return value
        if (found := read[at]) is None:
            name = names[at] if isinstance(names, list) and at < len(names) else ""
            checkpoint()
            try:
                found = taken(resources, files[at], {**question, "name": name})
            except DataError as error:
                found = {"problem": str(error)}
            read[at] = found
        return found.get("ref") or Unread(found["problem"])

    def filled(part: Any) -> Any:
        images = {key: part[key] for key in IMAGE_KEYS if isinstance(part, dict) and key in part}
        for key, value in images.items():
            many = isinstance(value, list)
            images[key] = [embedded(image) for image in value] if many else embedded(value)
        return {**part, **images} if images else part

    whole = {**filled(question)}
    for key in ("pairs", "lessons"):
        if isinstance(question.get(key), list):
            whole[key] = [filled(part) for part in question[key]]
    try:
        reply = work(resources, whole)
    except DataError as error:
        if not any(part and "problem" in part for part in read):
            raise
        reply = {"problem": str(error)}
    if isinstance(reply, InTwo):
        return replace(reply, first={**reply.first, "pictures": read})
    return {**reply, "pictures": read} if isinstance(reply, dict) else reply


def files_in(question: Question, most: int = 2, what: str = "picture") -> list[bytes]:
    """Return the pictures that came with a question; raises DataError for none or too many."""
    files: list[bytes] = question.get(FILES, [])
    if not 0 < len(files) <= most:
        raise DataError(
            f"{len(files)} pictures came with the question; send each {what} after it, 1 to {most}."
        )
    return files


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


def live(resources: Resources, question: Question) -> Reply:
    """Predict one picture, or a photo and a touch.

    question  {"modality": "vis", "tac" or "both"}, whose pictures came with it, a photo before its
              touch; and see `pair_request`
    return    classes, probabilities of each reading, `images`: modality -> whether the prediction
              is a `guess`, and milliseconds of encoder and head

    Raises DataError if the picture cannot be read or its modality is unknown.
    """
    import torch

    modality = one_of("modality", question.get("modality"), (*OTHER, BOTH))
    given = dict(zip(IMAGES if modality == BOTH else (modality,), files_in(question), strict=False))
    encoders = {name: resources.reader(name, lamps_in(resources, question)) for name in given}
    with torch.inference_mode():
        pixels = {
            name: encoders[name].preprocess(decoded(resources, content, question, name))
            for name, content in given.items()
        }
        began = perf_counter()
        rows = {name: encoders[name].embed(some[None]) for name, some in pixels.items()}
        embedded = perf_counter()
    named = pair_request(resources, question, rows)
    found = predict_one(named)
    ms = {"encoder": embedded - began, "head": perf_counter() - embedded}
    ms = {part: round(1000 * seconds, 1) for part, seconds in ms.items()}
    return {"classes": list(named.head.settings.classes), **found, "ms": ms}


def occlusion(resources: Resources, question: Question) -> Reply:
    """Hide each part of an image in turn, predict again, and measure the change of the probability.

    question  {"modality": "vis" or "tac", whose picture came with it; the other image}; and see
              `pair_request`
    return    the predicted class, its probability, and `drops` (CELLS, CELLS): the decrease of the
              probability when a part is hidden; negative for an increase

    Raises DataError if the image cannot be read or its modality is not "vis" or "tac".
    """
    import numpy as np
    import torch
    from PIL.Image import fromarray

    modality = one_of("modality", question.get("modality"), OTHER)
    image = decoded(resources, files_in(question)[0], question, modality)
    image.thumbnail((SIDE, SIDE))
    whole, mean = (torch.from_numpy(np.array(picture)) for picture in (image, image.resize((1, 1))))
    shown = [image, *(fromarray(part.numpy()) for part in hidden(whole[None], mean))]
    encoder = resources.reader(modality, lamps_in(resources, question))
    with torch.inference_mode():
        pixels = [encoder.preprocess(picture) for picture in shown]
        parts = []
        for few in torch.stack(pixels).split(AT_ONCE):
            checkpoint()
            parts.append(encoder.embed(few))
    named = pair_request(resources, question, {modality: torch.cat(parts)})
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
