"""Picture files of several frames, such as a TIFF stack or an animation, as recordings."""

from functools import partial
from pathlib import Path

from PIL import Image

from omnivat.data.images import opened, read_bytes, read_image, upright
from omnivat.data.recordings.tracks import Frames, Track
from omnivat.kit.errors import DataError

ENDINGS = (".tif", ".tiff", ".gif", ".apng", ".webp")


def count_in(file: Path) -> int:
    """Return the number of frames of one size in a picture file; 1 for any other file, and for one
    that cannot be read.
    """
    if file.suffix.lower() not in ENDINGS:
        return 1
    try:
        image = opened(read_bytes(file), file.name)
        count, size = int(getattr(image, "n_frames", 1)), image.size
        if count > 1:
            image.seek(1)
        return count if image.size == size else 1  # other sizes are reduced copies
    except (DataError, OSError, ValueError, SyntaxError, EOFError):
        return 1


def stack(file: Path) -> Track:
    """Return a picture file as a track that lasts one unit of time."""
    count = count_in(file)
    picture = partial(_frame, file) if count > 1 else lambda _: read_image(file)
    return Frames(file=file, times=[k / count for k in range(count)], picture=picture)


def _frame(file: Path, number: int) -> Image.Image:
    image = opened(read_bytes(file), file.name)
    try:
        image.seek(number)
    except (OSError, ValueError, SyntaxError, EOFError) as error:
        raise DataError(f"'{file}' is damaged after {number} frames.") from error
    return upright(image, f"{file.name}, frame {number}")
