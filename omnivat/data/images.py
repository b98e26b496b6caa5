"""Read an image of any common kind as upright 8-bit RGB, or say in one sentence why not.

What is decided here, so that the same picture gives the same pixels whatever file holds it:

- transparency is laid on white, so colours hidden under it never matter;
- 16-bit values keep their upper 8 bits, grey and colour alike; floating values must be in [0, 1];
- the EXIF rotation is applied, colour profiles are not;
- of an animation the first frame is taken.
"""

from io import BytesIO
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from omnivat.errors import DataError

MAX_PIXELS = 64_000_000  # read from the header, before a single pixel is decoded
MIN_SIDE = 8
FORMATS = ("PNG", "JPEG", "BMP", "GIF", "TIFF", "WEBP", "PPM", "QOI", "JPEG2000", "AVIF")
REMEDY = "save it as PNG or JPEG and try again"

_UPRIGHT = {  # EXIF orientation -> what turns the stored pixels upright
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}
_ORIENTATION = 0x0112


def read_image(source: str | Path | bytes | Image.Image, name: str = "") -> Image.Image:
    """Return the image in `source`, a path, a file's bytes or an open image, as upright RGB.

    name    what to call it in an error; the path where none is given

    Raises DataError, naming the file and the remedy, when it is missing, empty, cut short, not an
    image, over 64 megapixels, under 8 pixels on a side, or of values without a known range.
    """
    if isinstance(source, Image.Image):
        return _rgb(source, name or "the image")
    name = name or ("the image" if isinstance(source, bytes) else str(source))
    with BytesIO(read_bytes(source, name)) as handle:
        return _rgb(_open(handle, name), name)


def read_bytes(source: str | Path | bytes, name: str = "") -> bytes:
    """Return a file's bytes; raises DataError when it is missing, unreadable or empty."""
    name = name or str(source)
    if isinstance(source, bytes):
        content = source
    else:
        try:
            content = Path(source).read_bytes()
        except (OSError, ValueError) as error:  # a name from a table may hold a zero byte
            why = getattr(error, "strerror", None) or str(error)
            raise DataError(f"'{name}' cannot be read ({why}); check the path.") from error
    if not content:
        raise DataError(f"'{name}' is empty (0 bytes); copy or save the image again.")
    return content


def central_square(image: Image.Image, side: int) -> Image.Image:
    """Return the central `side` x `side` pixels (fewer where the image is smaller); 0 cuts nothing."""
    if side <= 0:
        return image
    side = min(side, *image.size)
    left, top = (image.width - side) // 2, (image.height - side) // 2
    return image.crop((left, top, left + side, top + side))


def _open(handle: IO[bytes], name: str) -> Image.Image:
    """Read the header only.

    `Image.open` would warn of large images, and silencing a warning is not safe beside threads;
    its own table of readers gives the size without the warning.
    """
    Image.init()
    start = handle.read(16)
    for kind in FORMATS:
        opener, accepts = Image.OPEN.get(kind, (None, None))
        if opener is None or accepts is None or accepts(start) is not True:
            continue
        handle.seek(0)
        try:
            return opener(handle, "")
        except Exception as error:  # a reader given bad bytes may raise anything
            raise DataError(f"'{name}' is a damaged {kind} file; {REMEDY}.") from error
    raise DataError(f"'{name}' is not an image of a known kind; {REMEDY}.")


def _rgb(image: Image.Image, name: str) -> Image.Image:
    _check_size(image, name)
    try:
        image.load()
        turn = _UPRIGHT.get(_turn(image))
        upright = image if turn is None else image.transpose(turn)
    except Exception as error:  # a decoder given bad bytes may raise anything
        raise DataError(f"'{name}' is cut short or damaged; {REMEDY}.") from error
    try:
        return _eight_bit_rgb(upright, name)
    except ValueError as error:
        if isinstance(error, DataError):
            raise
        raise DataError(f"'{name}' has colours of kind {image.mode}; {REMEDY}.") from error


def _check_size(image: Image.Image, name: str) -> None:
    width, height = image.size
    if width * height > MAX_PIXELS:
        raise DataError(
            f"'{name}' is {width} × {height} pixels, more than the {MAX_PIXELS // 10**6} megapixels "
            "that are read; scale it down and try again."
        )
    if min(width, height) < MIN_SIDE:
        raise DataError(
            f"'{name}' is {width} × {height} pixels; a side needs {MIN_SIDE} or more for a surface "
            "to be seen, so choose a larger image."
        )


def _turn(image: Image.Image) -> int:
    try:
        return int(image.getexif().get(_ORIENTATION, 1))
    except Exception:  # damaged EXIF says nothing about the pixels, which are good
        return 1


def _eight_bit_rgb(image: Image.Image, name: str) -> Image.Image:
    if image.mode.startswith("I"):
        image = Image.fromarray(_upper_byte(np.asarray(image), name))
    elif image.mode == "F":
        image = Image.fromarray(_from_unit_range(np.asarray(image), name))
    if image.has_transparency_data:
        seen = image.convert("RGBA")
        image = Image.alpha_composite(Image.new("RGBA", seen.size, "white"), seen)
    return image.convert("RGB") if image.mode != "RGB" else image.copy()


def _upper_byte(values: NDArray[Any], name: str) -> NDArray[np.uint8]:
    low, high = int(values.min()), int(values.max())
    if low < 0 or high > 65535:
        raise DataError(f"'{name}' holds values from {low} to {high}; save it as 8- or 16-bit PNG.")
    return (values.astype(np.uint32) >> 8).astype(np.uint8)


def _from_unit_range(values: NDArray[Any], name: str) -> NDArray[np.uint8]:
    low, high = float(values.min()), float(values.max())
    if not (low >= 0 and high <= 1):  # also true of NaN
        raise DataError(
            f"'{name}' holds floating values from {low:g} to {high:g}, expected 0 to 1; "
            "save it as 8- or 16-bit PNG."
        )
    scaled: NDArray[np.uint8] = np.rint(values * 255).astype(np.uint8)
    return scaled
