"""Strips: a signal as a picture of grey stripes, and the signal read back from it."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from omnivat.kit.errors import ShapeError

STRIPES = 64  # of every picture
SIDE = 256  # pixels of a picture: four for each stripe
MIDDLE, SWING = 127.5, 120.0  # grey of 0, and the largest distance from it
ENCODER = "strip"  # its name in the table of encoders
READER = "1"  # version, instead of a hash of weights
PREPROCESSING = f"{STRIPES} upright stripes, mean grey of each, less {MIDDLE}, over {SWING:g}"


def strip_picture(signal: NDArray[np.floating]) -> Image.Image:
    """Return a signal as vertical stripes from left to right, light for positive values.

    signal  (64,) finite values; the largest magnitude has full contrast, 0 is mid-grey
    return  256 x 256 pixels, RGB

    Raises ShapeError for another length.
    """
    values = np.asarray(signal, dtype=np.float64)
    if values.shape != (STRIPES,):
        raise ShapeError(f"A strip shows {STRIPES} values, got shape {values.shape}.")
    largest = float(np.abs(values).max()) or 1.0
    row = np.repeat(np.rint(MIDDLE + SWING * values / largest).astype(np.uint8), SIDE // STRIPES)
    return Image.fromarray(np.tile(row, (SIDE, 1))).convert("RGB")


def strip_signal(picture: Image.Image) -> NDArray[np.float32]:
    """Return the signal (64,) of a picture of any size and format.

    The picture is averaged over its height and over 64 equal vertical bands. For a picture made by
    `strip_picture`, the result is the signal scaled to a largest magnitude of 1, to half a grey
    level (0.004).
    """
    grey = picture.convert("RGB").convert("L").convert("F")
    bands = np.asarray(grey.resize((STRIPES, 1), Image.Resampling.BOX), dtype=np.float32)[0]
    return np.asarray((bands - np.float32(MIDDLE)) / np.float32(SWING))
