"""Replies to a request whose body is a picture: its name for later, a live prediction, or
occlusion.
"""

import base64
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from app.familiar import OTHER, predict_one
from app.pair_input import moved, of_ref
from app.resources import Resources
from app.state import Ref
from app.teaching import head_taught
from omnivat.kit.errors import DataError
from omnivat.kit.progress import checkpoint

if TYPE_CHECKING:
    from PIL import Image
    from torch import Tensor

BOTH = "both"
PREVIEW_SIDE = 320  # pixels of the preview
CELLS = 7  # of occlusion, for each side of the picture shown
PATCH = 2  # side of the hidden square, in cells; a single cell changes little
AT_ONCE = 8  # images embedded between two checks for a cancelled request
SIDE = 448  # pixels; the image is first scaled down to this, encoders use 224


@dataclass(frozen=True, slots=True, kw_only=True)
class Sent:
    """A picture and the parameters of its request."""

    content: bytes | Path  # its bytes, or their file; with BOTH: of the photo, then of the touch
    modality: str = ""  # "vis", "tac" or BOTH
    split: int = 0  # the bytes of the photo, with BOTH
    other: Ref | None = None  # the other image of the pair; None to predict without it
    order: float | None = None  # p in quarter turns; None: the learned one
    name: str = "the image"
    # name of a taught head, from `app.teaching.taught_name`; "": the head as trained
    taught: str = ""
    head: str = ""  # name of a head; "": the first one
    profile: str = ""  # name of a profile, from `app.sensor`; "": images as they come

    def pair(
        self, resources: Resources, rows: "Mapping[str, Tensor]"
    ) -> "dict[str, Tensor | None]":
        """Return the embeddings of both modalities: `rows` (B, W) of the pictures sent, and the
        other image.
        """
        asked = {"profile": self.profile, "head": self.head}
        pair: dict[str, Tensor | None] = {"vis": None, "tac": None}
        for own, some in rows.items():
            pair[own] = moved(resources, asked, own, some)
            if self.other is not None and self.modality != BOTH:
                rest = OTHER[own]
                pair[rest] = of_ref(resources, self.other, rest, asked).expand(len(some), -1)
        return pair


def taken(resources: Resources, sent: Sent) -> dict[str, Any]:
    """Embed an image; return its name and a small preview. The picture itself is not kept."""
    ref, found = resources.take_image(sent.content, sent.name)
    return {
        "ref": str(ref),
        "width": found.width,
        "height": found.height,
        "preview": preview(found.image),
    }


def preview(image: "Image.Image") -> str:
    """Return a small JPEG of the image, upright, as a data URL."""
    small = image.reduce(max(1, max(image.size) // PREVIEW_SIDE))  # a fifth of the time
    small.thumbnail((PREVIEW_SIDE, PREVIEW_SIDE))
    with BytesIO() as handle:
        small.save(handle, "JPEG", quality=85)
        return "data:image/jpeg;base64," + base64.b64encode(handle.getvalue()).decode()


def live(resources: Resources, sent: Sent) -> dict[str, Any]:
    """Predict one picture with the other image of the pair if given, or a photo and a touch.

    return  classes, probabilities of each reading, `images`: modality -> whether the prediction
            is a `guess`, and milliseconds of each part

    Raises DataError if the picture cannot be read or its modality is unknown.
    """
    import torch

    from omnivat.encoders.base import for_modality

    began = perf_counter()
    head, known = head_taught(resources, sent.taught, sent.head)
    read = resources.shared.decoder.read
    with torch.inference_mode():
        pixels = {
            one: for_modality(resources.encoder(), one).preprocess(read(part, sent.name).image)
            for one, part in _parts(sent).items()
        }
        decoded = perf_counter()
        rows = {
            one: for_modality(resources.encoder(), one).embed(some[None])
            for one, some in pixels.items()
        }
        embedded = perf_counter()
        before = replace(sent, profile="").pair(resources, rows)
        found = predict_one(head, sent.pair(resources, rows), sent.order, known, before=before)
    ms = {"read": decoded - began, "encoder": embedded - decoded, "head": perf_counter() - embedded}
    ms = {part: round(1000 * seconds, 1) for part, seconds in ms.items()}
    return {"classes": list(head.settings.classes), **found, "ms": ms}


def _parts(sent: Sent) -> dict[str, bytes | Path]:
    """Return modality -> content of each picture in a request."""
    content = sent.content
    if sent.modality in OTHER:
        return {sent.modality: content}
    if sent.modality != BOTH:
        raise DataError(f"modality is '{sent.modality:.20}'; it is vis, tac or both.")
    whole = content.read_bytes() if isinstance(content, Path) else content
    if not 0 < sent.split < len(whole):
        raise DataError(
            f"split is {sent.split}; give the bytes of the photo, before those of the touch."
        )
    return {"vis": whole[: sent.split], "tac": whole[sent.split :]}


def occlusion(resources: Resources, sent: Sent) -> dict[str, Any]:
    """Hide each part of an image in turn, predict again, and measure the change of the probability.

    return  the predicted class, its probability, and `drops` (CELLS, CELLS): the decrease of the
            probability when a part is hidden; negative for an increase

    Raises DataError if the image cannot be read or its modality is not "vis" or "tac".
    """
    if sent.modality not in OTHER:
        raise DataError(f"modality is '{sent.modality:.20}'; it is vis or tac.")
    import torch

    from omnivat.encoders.base import for_modality

    began = perf_counter()
    image = resources.shared.decoder.read(sent.content, sent.name).image
    image.thumbnail((SIDE, SIDE))
    encoder = for_modality(resources.encoder(), sent.modality)
    head, _ = head_taught(resources, sent.taught, sent.head)
    with torch.inference_mode():
        pixels = [encoder.preprocess(one) for one in (image, *hidden(image))]
        parts = []
        for few in torch.stack(pixels).split(AT_ONCE):
            checkpoint()
            parts.append(encoder.embed(few))
        pair = sent.pair(resources, {sent.modality: torch.cat(parts)})
        probabilities = head.model(pair["vis"], pair["tac"], order=sent.order).probabilities
        predicted = int(probabilities[0].argmax())
        falls = probabilities[0, predicted] - probabilities[1:, predicted]
    steps = CELLS - PATCH + 1
    return {
        "class": head.settings.classes[predicted],
        "probability": round(float(probabilities[0, predicted]), 6),
        "cells": CELLS,
        "drops": over_cells(falls.reshape(steps, steps).tolist()),
        "seconds": round(perf_counter() - began, 2),
    }


def hidden(image: "Image.Image") -> Iterator["Image.Image"]:
    """Yield the image with one part after the other filled with its mean colour, row by row."""
    width, height = image.size
    mean: Any = image.resize((1, 1)).getpixel((0, 0))
    across = [(k * width // CELLS, (k + PATCH) * width // CELLS) for k in range(CELLS - PATCH + 1)]
    down = [(k * height // CELLS, (k + PATCH) * height // CELLS) for k in range(CELLS - PATCH + 1)]
    for top, bottom in down:
        for left, right in across:
            copy = image.copy()
            copy.paste(mean, (left, top, right, bottom))
            yield copy


def over_cells(falls: list[list[float]]) -> list[list[float]]:
    """Return the mean decrease for each cell, over the parts that cover it."""
    covering = [range(max(0, k - PATCH + 1), min(len(falls), k + 1)) for k in range(CELLS)]
    return [
        [
            round(sum(falls[r][c] for r in rows for c in columns) / (len(rows) * len(columns)), 6)
            for columns in covering
        ]
        for rows in covering
    ]
