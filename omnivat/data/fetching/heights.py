"""Height maps in pickles, read without running anything, and drawn as the touch image they stand
for.
"""

from math import prod

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from omnivat.kit.errors import DataError, first_line
from omnivat.kit.pickles import read_array

CELLS = 16_000_000  # of a height map
RELIEF = 8.0  # of the slopes of a map whose spread is 1: shows grain and leaves edges unclipped
LAMPS = ((0.0, 1.0), (0.87, -0.5), (-0.87, -0.5))  # directions of red, green and blue, 120° apart


def load_heights(content: bytes, name: str) -> NDArray[np.float32]:
    """Return the height map (H, W) in a pickle of one NumPy array of numbers.

    The file is read as data, in a process with limits; nothing in it runs.
    Raises DataError, with `name`, for anything else in the file, and for over 16 million heights.
    """
    try:
        about, values = read_array(content, over="it takes too much memory or time")
        shape = about["shape"][: 2 if about["shape"][2:] == [1] else None]
        if len(shape) != 2 or min(shape) < 8 or prod(shape) > CELLS:
            raise ValueError(f"{about['dtype']} of shape {tuple(about['shape'])}")
        heights = np.frombuffer(values, about["dtype"]).reshape(shape, order=about["order"])
        if not np.isfinite(heights).all():
            raise ValueError("heights that are not finite")
    except (DataError, ValueError, TypeError) as error:
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
