"""Height maps in pickles, read without running anything, and drawn as the touch image they stand
for.
"""

import pickle
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from omnivat.kit.errors import DataError, first_line

KNOWN = {  # names in a pickle of one array
    ("numpy.core.multiarray", "_reconstruct"),
    ("numpy.core.numeric", "_frombuffer"),
    ("numpy", "ndarray"),
    ("numpy", "dtype"),
    ("_codecs", "encode"),
}
RELIEF = 8.0  # of the slopes of a map whose spread is 1: shows grain and leaves edges unclipped
LAMPS = ((0.0, 1.0), (0.87, -0.5), (-0.87, -0.5))  # directions of red, green and blue, 120° apart


class _Opener(pickle.Unpickler):
    """An unpickler that knows the names of an array of numbers alone."""

    def find_class(self, module: str, name: str) -> Any:
        if (module.replace("_core", "core"), name) in KNOWN:
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"the name {module}.{name}")


def load_heights(content: bytes, name: str) -> NDArray[np.float32]:
    """Return the height map (H, W) in a pickle of one NumPy array of numbers.

    No code of the file runs: names other than those of an array are refused.
    Raises DataError, with `name`, for anything else in the file.
    """
    try:
        heights = np.asarray(_Opener(BytesIO(content)).load())
        if heights.shape[2:] == (1,):
            heights = heights[..., 0]
        if heights.ndim != 2 or min(heights.shape) < 8 or heights.dtype.kind not in "fiu":
            raise ValueError(f"{heights.dtype} of shape {heights.shape}")
        if not np.isfinite(heights).all():
            raise ValueError("heights that are not finite")
    except Exception as error:  # a damaged file finds an error of every kind
        raise DataError(
            f"'{name}' is no pickle of one height map ({first_line(error)}); nothing of it was run."
        ) from error
    return heights.astype(np.float32)


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
