"""Occlusion: hide one part of an image at a time and measure the change of the probability."""

from collections.abc import Callable, Iterator
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from app.pair_input import moved, of_ref
from app.resources import Resources
from app.state import Ref
from app.teaching import head_taught
from omnivat.errors import DataError

if TYPE_CHECKING:
    from PIL import Image

CELLS = 7  # for each side of the picture shown
PATCH = 2  # side of the hidden square, in cells; a single cell changes little
AT_ONCE = 8  # images embedded between two checks for a cancelled request
SIDE = 448  # pixels; the image is first scaled down to this, encoders use 224


def occlusion(
    resources: Resources,
    content: bytes | Path,
    *,
    modality: str,
    other: Ref | None,
    order: float | None,
    name: str = "the image",
    taught: str = "",
    profile: str = "",
    check: Callable[[], None] = lambda: None,
) -> dict[str, Any]:
    """Hide each part of an image in turn and predict again.

    content   the bytes of the image or their file
    check     called between parts; an error it raises ends the work
    modality  "vis" or "tac"
    other     the other image of the pair, unchanged; None to predict without it
    order     p in quarter turns; None: the learned one
    taught    name of a taught head, from `app.teaching.taught_name`; "": the head as trained
    profile   name of a profile, from `app.sensor`; "": images as they come
    return    the predicted class, its probability, and `drops` (CELLS, CELLS): the decrease of
              the probability when a part is hidden; negative for an increase

    Raises DataError if the image cannot be read or `modality` is unknown.
    """
    if modality not in ("vis", "tac"):
        raise DataError(f"modality is '{modality:.20}'; it is vis or tac.")
    import torch

    from omnivat.encoders.base import for_modality

    began = perf_counter()
    image = resources.picture(content, name, check).image
    image.thumbnail((SIDE, SIDE))
    encoder = for_modality(resources.encoder(), modality)
    head = head_taught(resources, taught)
    with torch.inference_mode():
        pixels = [encoder.preprocess(one) for one in (image, *hidden(image))]
        parts = []
        for few in torch.stack(pixels).split(AT_ONCE):
            check()
            parts.append(encoder.embed(few))
        asked = {"profile": profile}
        varied = moved(resources, asked, modality, torch.cat(parts))
        pair: dict[str, Any] = {"vis": None, "tac": None, modality: varied}
        if other is not None:
            rest = "tac" if modality == "vis" else "vis"
            pair[rest] = of_ref(resources, other, rest, asked).expand(len(varied), -1)
        probabilities = head.model(pair["vis"], pair["tac"], order=order).probabilities
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
    steps = CELLS - PATCH + 1
    for row in range(steps):
        for column in range(steps):
            box = (
                column * width // CELLS,
                row * height // CELLS,
                (column + PATCH) * width // CELLS,
                (row + PATCH) * height // CELLS,
            )
            copy = image.copy()
            copy.paste(mean, box)
            yield copy


def over_cells(falls: list[list[float]]) -> list[list[float]]:
    """Return the mean decrease for each cell, over the parts that cover it."""
    steps = len(falls)
    rows = []
    for row in range(CELLS):
        cells = []
        for column in range(CELLS):
            covering = [
                falls[r][c]
                for r in range(max(0, row - PATCH + 1), min(steps, row + 1))
                for c in range(max(0, column - PATCH + 1), min(steps, column + 1))
            ]
            cells.append(round(sum(covering) / len(covering), 6))
        rows.append(cells)
    return rows
