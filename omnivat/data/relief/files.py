"""Lamps as text for headers, the marks of sets whose touches are drawn as relief, and which
pictures of a domain give its lamps.
"""

import json
from base64 import b64decode, b64encode
from collections.abc import Sequence
from io import BytesIO
from typing import TypeVar

import numpy as np
from PIL import Image

from omnivat.data.images import opened, upright
from omnivat.data.relief.lamps import Lamps
from omnivat.kit.errors import DataError
from omnivat.kit.schema import object_in

RELIEF = "; TAC drawn as its relief"  # in a set's preprocessing, after the dots
MARKS = {"relief": RELIEF, "both": "; TAC in colours beside its relief"}
READ = {  # how touch is read, the first by default, in words
    "colours": "in its colours",
    "relief": "as its relief",
    "both": "in its colours and as its relief",
}
TOUCH = tuple(READ)
MOST = 50  # pictures of a domain that give its lamps
MOST_PIXELS = 250_000  # of a background, above any that `lamps` makes
MOST_PICTURES = 10**12  # above any that a file can count
NUMBERS = ("ratio", "confidence", "pictures", "steepness")
T = TypeVar("T")


def touch_of(preprocessing: str) -> str:
    """Return how a set's preprocessing took touch: one of `TOUCH`.

    >>> touch_of("resized to 224; dots of TAC filled; TAC drawn as its relief")
    'relief'
    """
    return next((name for name, mark in MARKS.items() if mark in preprocessing), TOUCH[0])


def unmarked(preprocessing: str) -> str:
    """Return a set's preprocessing without how it took touch."""
    return preprocessing.replace(MARKS.get(touch_of(preprocessing), ""), "")


def reading_of(touch: str, lamps: Lamps | str | None, of: str = "") -> str:
    """Return how touch is read, and by whose lamps, in words that go on from "touch is read".

    of  whose touches gave the lamps

    >>> reading_of("relief", None)
    'as its relief, by the lamps that each touch gives alone'
    """
    by = ", by the lamps that each touch gives alone"
    if isinstance(lamps, Lamps):
        by = f", by lamps from {lamps.pictures} touches{of} (confidence {lamps.confidence:.2f})"
    return READ[touch] + by * (touch != TOUCH[0])


def spread(items: Sequence[T], most: int = MOST) -> list[T]:
    """Return at most `most` of the items, evenly spread, from the first to the last.

    >>> spread("abcdefghi", 3)
    ['a', 'e', 'i']
    """
    index = np.linspace(0, len(items) - 1, min(most, len(items))).round().astype(int)
    return [items[i] for i in index]


def packed(lamps: Lamps) -> str:
    """Return lamps as JSON, from which `unpacked` makes exactly the same."""
    record = {name: getattr(lamps, name) for name in NUMBERS} | {"colours": lamps.colours.tolist()}
    if lamps.background is not None:
        with BytesIO() as file:
            Image.fromarray(lamps.background).save(file, "PNG")
            record["background"] = b64encode(file.getvalue()).decode()
    return json.dumps(record)


def unpacked(text: str) -> Lamps:
    """Return the lamps of `packed`; raises DataError for another text."""
    record = object_in(text.encode(), "lamps")
    try:
        steepness, background = record["steepness"], record.get("background")
        found = Lamps(
            colours=np.array(record["colours"], float),
            background=None if background is None else _pixels(background),
            ratio=float(record["ratio"]),
            confidence=float(record["confidence"]),
            pictures=int(record["pictures"]),
            steepness=None if steepness is None else float(steepness),
        )
    except DataError:
        raise
    except (KeyError, TypeError, ValueError) as error:
        raise DataError(f"The lamps cannot be read ({error!s:.80}); make them again.") from error
    shares = -0.01 <= found.ratio <= 1.01 and -0.01 <= found.confidence <= 1.01  # false of NaN
    if not (shares and 0 < found.pictures < MOST_PICTURES):
        raise DataError(
            f"The lamps' ratio {found.ratio:g} and confidence {found.confidence:g} are to be shares"
            f" from 0 to 1, and their pictures 1 to {MOST_PICTURES:.0e}; make them again."
        )
    return found


def _pixels(background: str) -> "np.ndarray[tuple[int, ...], np.dtype[np.uint8]]":
    name = "the lamps' background"
    try:
        image = opened(b64decode(background), name, kinds=["PNG"], pixels=MOST_PIXELS)
        return np.asarray(upright(image, name, reduced=False))
    except DataError as error:
        raise DataError(
            f"The lamps' background is no PNG of up to {MOST_PIXELS:,} pixels; make them again."
        ) from error
