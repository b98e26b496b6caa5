"""Read an image of any common kind as upright 8-bit RGB, or raise an error of one sentence.

The same picture gives the same pixels from any file format:

- transparency is blended with white, so hidden colours have no effect;
- 16-bit values keep their upper 8 bits, grey and colour alike; floating values must be in [0, 1];
- the EXIF rotation is applied, colour profiles are not;
- only the first frame of an animation is used;
- a picture with a shorter side over 2,047 pixels, or over 6 megapixels, is reduced by an integer
  factor; encoders use 224 pixels.

Pillow reads the header first; too many pixels are refused then. A file made to cost memory or time
gets both here: the page reads visitors' files in a process that has little of either
(`app/decoder.py`).
"""

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image

from omnivat.kit.errors import DataError
from omnivat.kit.files import read_whole

warnings.filterwarnings("ignore", category=UserWarning, module="PIL")  # of damaged notes in a file

ORIENTATION = 0x0112  # tag of EXIF
MAX_PIXELS = 64_000_000  # checked in the header, before decoding
MAX_FILE_BYTES = 300_000_000
MIN_SIDE, MAX_SIDE = 8, 65_535  # pixels; JPEG and GIF have no longer side
SHORT_SIDE = 1024  # lower limit of a reduced picture
STRIP_PIXELS = 1_000_000
MOST_PIXELS = 6_000_000  # upper limit of a reduced picture
COMMON = ("PNG", "JPEG", "WEBP", "GIF", "BMP", "TIFF")
FORMATS = (*COMMON, "PPM", "QOI", "JPEG2000", "AVIF")
REMEDY = "save it as PNG or JPEG and try again"

_MODULES = {"JPEG2000": "Jpeg2KImagePlugin", "WEBP": "WebPImagePlugin"}
_UPRIGHT = {  # EXIF orientation -> rotation to upright
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}


VISITORS: dict[str, Any] = {"kinds": COMMON, "pixels": 24_000_000}  # of uploads, for `opened`


def read_image(
    source: str | Path | bytes | Image.Image, name: str = "", *, reduced: bool = True
) -> Image.Image:
    """Return the image in `source`, a path, a file's bytes or an open image, as upright RGB.

    name     its name in errors; None: the path
    reduced  True reduces a large picture; False keeps every pixel

    Raises DataError, with the file and the remedy, if it is missing, empty, truncated, not an
    image, over the limits, under 8 pixels on a side, or has values without a known range.
    """
    name = name or ("the image" if isinstance(source, bytes | Image.Image) else str(source))
    if not isinstance(source, Image.Image):
        source = opened(read_bytes(source, name), name)
    return upright(source, name, reduced=reduced)


def opened(
    content: bytes, name: str, *, kinds: Sequence[str] = FORMATS, pixels: int = MAX_PIXELS
) -> Image.Image:
    """Return the image in a file's bytes, of which only the header is read.

    kinds   accepted ones
    pixels  most of a kind that cannot be decoded at reduced size, as JPEG can

    `Image.open` would warn about large images, so Pillow's readers are tried in turn.
    Raises DataError as `read_image` does.
    """
    for kind in kinds:
        import_module(f"PIL.{_MODULES.get(kind, kind.capitalize() + 'ImagePlugin')}")
        opener, accepts = Image.OPEN[kind]
        if accepts and accepts(content[:16]):
            break
    else:
        raise DataError(f"'{name}' is not an image of a known kind; {REMEDY}.")
    with _explained(name, f"is a damaged {kind} file"):
        image = opener(BytesIO(content), "")
    check_size(*image.size, name)
    if kind != "JPEG" and image.width * image.height > pixels:
        raise DataError(
            f"'{name}' is {image.width} × {image.height} pixels; a {kind} file is read up to "
            f"{pixels / 1e6:.0f} megapixels here. Scale it down, or save it as JPEG."
        )
    return image


@contextmanager
def _explained(name: str, what: str) -> Iterator[None]:
    """Turn any error of a decoder into a DataError."""
    try:
        yield
    except DataError:
        raise
    except MemoryError as error:
        raise DataError(
            f"'{name}' takes more memory to read than there is; scale it down, or save it as JPEG."
        ) from error
    except Exception as error:  # a decoder may raise any error for bad bytes
        raise DataError(f"'{name}' {what}; {REMEDY}.") from error


def factor(width: int, height: int) -> int:
    """Return the integer divisor of a picture's sides.

    >>> factor(2000, 3000), factor(3000, 4000), factor(100, 640_000)
    (1, 2, 4)
    """
    short = min(width, height)
    found = max(1, short // SHORT_SIDE)
    while width * height > MOST_PIXELS * found**2 and short // (found + 1) >= MIN_SIDE:
        found += 1
    return found


def draft_scale(width: int, height: int) -> int:
    """Return the reduction of a JPEG while decoding: 1, 2, 4 or 8."""
    wanted = factor(width, height)
    return max(scale for scale in (1, 2, 4, 8) if scale <= wanted)


def read_bytes(source: str | Path | bytes, name: str = "") -> bytes:
    """Return a file's bytes; raises DataError if it is missing, unreadable or empty."""
    name = name or str(source)
    content = source if isinstance(source, bytes) else read_whole(source, MAX_FILE_BYTES, name)
    if not content:
        raise DataError(f"'{name}' is empty (0 bytes); copy or save the image again.")
    return content


def central_square(image: Image.Image, side: int) -> Image.Image:
    """Crop to the central `side` x `side` pixels, or fewer in a smaller image; 0: no crop."""
    if side <= 0:
        return image
    side = min(side, *image.size)
    left, top = (image.width - side) // 2, (image.height - side) // 2
    return image.crop((left, top, left + side, top + side))


def upright(image: Image.Image, name: str, *, reduced: bool = True) -> Image.Image:
    """Return an open image as upright RGB; arguments and errors as for `read_image`."""
    check_size(*image.size, name)
    with _explained(name, "is cut short or damaged"):
        if reduced:
            scale = draft_scale(*image.size)
            image.draft(None, (image.width // scale, image.height // scale))  # only JPEG does
        image.load()
        turned = _UPRIGHT.get(_turn(image))
        seen = _eight_bit_rgb(image, name, factor(*image.size) if reduced else 1)
    return seen if turned is None else seen.transpose(turned)


def check_size(width: int, height: int, name: str) -> None:
    """Raise DataError for a picture, or a film's, of more or fewer pixels than are read."""
    size, most = f"'{name}' is {width} × {height} pixels", MAX_PIXELS // 10**6
    if width * height > MAX_PIXELS:
        raise DataError(
            f"{size}, more than the {most} megapixels that are read; scale it down and try again."
        )
    if max(width, height) > MAX_SIDE:
        raise DataError(f"{size}, and a side may have {MAX_SIDE:,}; crop it and try again.")
    if min(width, height) < MIN_SIDE:
        raise DataError(
            f"{size}; a side needs {MIN_SIDE} or more for a surface to be seen, so choose a larger"
            " image."
        )


def _turn(image: Image.Image) -> int:
    try:
        return int(image.getexif().get(ORIENTATION, 1))
    except Exception:  # damaged EXIF does not mean damaged pixels
        return 1


def _eight_bit_rgb(image: Image.Image, name: str, smaller: int) -> Image.Image:
    """Return the picture as RGB, its sides divided by `smaller`, strip by strip."""
    upper = _levels(image, name)
    width, height = image.size
    out = Image.new("RGB", (-(-width // smaller), -(-height // smaller)))
    step = smaller * max(1, STRIP_PIXELS // (width * smaller))
    for top in range(0, height, step):
        strip = image.crop((0, top, width, min(height, top + step)))
        rgb = _on_white(strip if upper is None else upper(strip))
        out.paste(rgb.reduce(smaller) if smaller > 1 else rgb, (0, top // smaller))
    return out


def _on_white(strip: Image.Image) -> Image.Image:
    if strip.has_transparency_data:
        seen = strip.convert("RGBA")
        strip = Image.alpha_composite(Image.new("RGBA", seen.size, "white"), seen)
    return strip.convert("RGB")


def _levels(image: Image.Image, name: str) -> Callable[[Image.Image], Image.Image] | None:
    """Return a function from the picture's values to 8 bits; None if it has 8 bits."""
    floating = image.mode == "F"
    if not (floating or image.mode.startswith("I")):
        return None
    import numpy as np

    if not image.mode.startswith("I;16"):  # of which no value is outside
        step = max(1, STRIP_PIXELS // image.width)
        boxes = [
            (0, top, image.width, min(image.height, top + step))
            for top in range(0, image.height, step)
        ]
        ends = [
            (values.min(), values.max())
            for values in (np.asarray(image.crop(box)) for box in boxes)
        ]
        low, high, most = float(np.min(ends)), float(np.max(ends)), 1 if floating else 65535
        if not (low >= 0 and high <= most):  # also true of NaN
            raise DataError(
                f"'{name}' holds values from {low:.9g} to {high:.9g}, expected 0 to {most}; save it"
                " as 8- or 16-bit PNG."
            )

    def eight_bits(strip: Image.Image) -> Image.Image:
        values = np.asarray(strip)
        return Image.fromarray(
            (np.rint(values * 255) if floating else values.astype(np.uint32) >> 8).astype(np.uint8)
        )

    return eight_bits
