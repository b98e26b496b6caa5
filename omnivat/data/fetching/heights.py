"""Height maps in pickles, read without running anything, and drawn as the touch image they stand
for.
"""

import pickle
import re
from io import BytesIO
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from omnivat.kit.errors import DataError

NUMBERS = re.compile(r"[fiu][1248]")
MOST = 64_000_000  # numbers of a map
RELIEF = 8.0  # of the slopes of a map whose spread is 1: shows grain and leaves edges unclipped
LAMPS = ((0.0, 1.0), (0.87, -0.5), (-0.87, -0.5))  # directions of red, green and blue, 120° apart


class _Opener(pickle._Unpickler):
    """An unpickler in which the names of NumPy stand for notes of what to build; no other name is
    known.

    It is the interpreter's own in Python: the one in C reserves memory that a hostile file asks
    for.
    """

    def find_class(self, module: str, name: str) -> Any:
        plain = module.replace("_core", "core")
        if (plain, name) == ("numpy.core.multiarray", "_reconstruct"):
            return lambda *_: _Note("array")
        if (plain, name) == ("numpy.core.numeric", "_frombuffer"):
            return lambda raw, kind, shape, order: _Note(
                "array", (1, shape, kind, order == "F", raw)
            )
        if (module, name) == ("numpy", "dtype"):
            return lambda code, *_: _Note("dtype", code=code)
        if (module, name) == ("numpy", "ndarray"):
            return None
        if (module, name) == ("_codecs", "encode"):
            return lambda text, *_: text.encode("latin1")
        raise pickle.UnpicklingError(f"the name {module}.{name}")


class _Note:
    """An array or a kind of number as a pickle describes it."""

    def __init__(self, what: str, state: Any = None, code: Any = "") -> None:
        self.what, self.state, self.code = what, state, code

    def __setstate__(self, state: Any) -> None:
        self.state = state


def load_heights(content: bytes, name: str) -> NDArray[np.float32]:
    """Return the height map (H, W) in a pickle of one NumPy array of numbers.

    No code of the file runs: names other than those of an array are refused.
    Raises DataError, with `name`, for anything else in the file.
    """
    try:
        note = _Opener(BytesIO(content)).load()
        _, shape, kind, fortran, raw = note.state
        order = kind.state[1] if kind.state else "|"
        if (
            note.what != "array"
            or not NUMBERS.fullmatch(kind.code)
            or order not in ("<", ">", "|", "=")
        ):
            raise ValueError("no array of numbers")
        shape = tuple(map(int, shape))
        if len(shape) == 3 and shape[-1] == 1:
            shape = shape[:2]
        if len(shape) != 2 or min(shape) < 8 or prod(shape) > MOST:
            raise ValueError(f"the shape {shape}")
        values = np.frombuffer(raw, np.dtype(order.replace("|", "<") + kind.code))
        map_ = values.reshape(shape, order="F" if fortran else "C").astype(np.float32)
    except Exception as error:  # a hostile file finds an error of every kind
        why = " ".join(str(error).split())[:100]
        raise DataError(
            f"'{name}' is no pickle of one height map ({why}); nothing of it was run."
        ) from error
    if not np.isfinite(map_).all():
        raise DataError(f"'{name}' has heights that are not finite.")
    return map_


def drawn(heights: NDArray[np.float32]) -> Image.Image:
    """Return a height map (H, W) as a gel under a red, a green and a blue lamp, 120° apart.

    Each channel is 0.5 + 0.5 n·l with the unit normal n of the surface and the horizontal direction
    l of its lamp (Lambertian photometric stereo: Johnson and Adelson, 2009). Heights are first
    divided by their spread, because the unit of a data set's heights may be unknown: a rendering,
    not the picture that the sensor took.
    """
    scaled = (heights - heights.mean()) / max(float(heights.std()), 1e-9)
    down, right = np.gradient(scaled * RELIEF)
    length = np.sqrt(down**2 + right**2 + 1)
    channels = [0.5 - 0.5 * (x * right + y * down) / length for x, y in LAMPS]
    return Image.fromarray(np.rint(np.stack(channels, -1) * 255).astype(np.uint8))
