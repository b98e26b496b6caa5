"""Read an image of any common kind as upright 8-bit RGB, or raise an error of one sentence.

The same picture gives the same pixels from any file format:

- transparency is blended with white, so hidden colours have no effect;
- 16-bit values keep their upper 8 bits, grey and colour alike; floating values must be in [0, 1];
- the EXIF rotation is applied, colour profiles are not;
- only the first frame of an animation is used;
- a picture with a shorter side over 2,047 pixels, or over 6 megapixels, is reduced by an integer
  factor; encoders use 224 pixels.

The header is read first. Too large files and unsupported kinds are refused then.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from io import BytesIO
from pathlib import Path

from PIL import Image

from omnivat.data.bare_files import ORIENTATION, bare_file
from omnivat.data.image_files import Content, ImageFile, OddFileError, image_file
from omnivat.kit.errors import DataError
from omnivat.kit.files import read_whole

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """Limits: accepted kinds, and the memory for decoding."""

    kinds: tuple[str, ...] = FORMATS
    cost: int = 260_000_000
    pixels: int = MAX_PIXELS  # for kinds that cannot be decoded at reduced size, as JPEG can
    variants: bool = True  # slow variants of a kind, such as run lengths in a BMP


OWN = Limits()  # the user's own files, on the command line
VISITORS = Limits(kinds=COMMON, cost=64_000_000, pixels=24_000_000, variants=False)  # uploads


def read_image(
    source: str | Path | bytes | Image.Image,
    name: str = "",
    *,
    limits: Limits = OWN,
    reduced: bool = True,
) -> Image.Image:
    """Return the image in `source`, a path, a file's bytes or an open image, as upright RGB.

    name     its name in errors; None: the path
    limits   accepted kinds, and memory for decoding
    reduced  True reduces a large picture; False keeps every pixel

    Raises DataError, with the file and the remedy, if it is missing, empty, truncated, not an
    image, over the limits, under 8 pixels on a side, or has values without a known range.
    """
    if isinstance(source, Image.Image):
        return _rgb(source, name or "the image", reduced=reduced)
    name = name or ("the image" if isinstance(source, bytes) else str(source))
    content = read_bytes(source, name)
    found = examined(content, name, limits=limits, reduced=reduced)
    content, turn = bare_file(content, found.kind)
    del source
    with BytesIO(content) as handle:
        image = _open(handle, found, name)
        _check_cost(
            replace(found, width=image.width, height=image.height), name, limits, reduced=reduced
        )
        return _rgb(image, name, reduced=reduced, turn=turn)


def examined(
    content: Content, name: str, *, limits: Limits = OWN, reduced: bool = True
) -> ImageFile:
    """Return facts from the header of an accepted file.

    Raises DataError as `read_image` does; no pixel is decoded.
    """
    try:
        found = image_file(content)
    except OddFileError as error:
        raise DataError(f"'{name}' {error}; {REMEDY}.") from error
    if found is None:
        raise DataError(f"'{name}' is not an image of a known kind; {REMEDY}.")
    if found.kind not in limits.kinds or not (found.usual or limits.variants):
        raise DataError(f"'{name}' is a {found.kind} file of a kind not taken here; {REMEDY}.")
    if found.pixels:
        _check_size(found.width, found.height, name)
        _check_cost(found, name, limits, reduced=reduced)
    return found


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


def _open(handle: BytesIO, facts: ImageFile, name: str) -> Image.Image:
    """Read the header only.

    `Image.open` would warn about large images, and silencing a warning is not thread-safe. PIL's
    table of readers gives the size without the warning.
    """
    kind = facts.kind
    try:
        import_module(f"PIL.{_MODULES.get(kind, kind.capitalize() + 'ImagePlugin')}")
        opener, _ = Image.OPEN[kind]
        return opener(handle, "")
    except Exception as error:  # a reader may raise any error for bad bytes
        raise DataError(f"'{name}' is a damaged {kind} file; {REMEDY}.") from error


def _rgb(image: Image.Image, name: str, *, reduced: bool, turn: int | None = None) -> Image.Image:
    _check_size(*image.size, name)
    try:
        if reduced:
            scale = draft_scale(*image.size)
            image.draft(None, (image.width // scale, image.height // scale))  # only JPEG does
        image.load()
        upright = _UPRIGHT.get(_turn(image) if turn is None else turn)
    except Exception as error:  # a decoder may raise any error for bad bytes
        raise DataError(f"'{name}' is cut short or damaged; {REMEDY}.") from error
    try:
        seen = _eight_bit_rgb(image, name, factor(*image.size) if reduced else 1)
    except DataError:
        raise
    except ValueError as error:
        raise DataError(f"'{name}' has colours of kind {image.mode}; {REMEDY}.") from error
    return seen if upright is None else seen.transpose(upright)


def _check_size(width: int, height: int, name: str) -> None:
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


def _check_cost(facts: ImageFile, name: str, limits: Limits, *, reduced: bool) -> None:
    width, height = facts.width, facts.height
    large = facts.kind != "JPEG" and facts.pixels > limits.pixels
    if large or facts.cost(draft_scale(width, height) if reduced else 1) > limits.cost:
        most = min(limits.pixels, limits.cost / facts.bytes_a_pixel) / 1e6
        raise DataError(
            f"'{name}' is {width} × {height} pixels; a {facts.kind} file of its kind is read up to "
            f"{most:.0f} megapixels here. Scale it down, or save it as JPEG."
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
        low, high = float(np.min(ends)), float(np.max(ends))
        if floating and not (low >= 0 and high <= 1):  # also true of NaN
            what = f"floating values from {low:g} to {high:g}, expected 0 to 1"
            raise DataError(f"'{name}' holds {what}; save it as 8- or 16-bit PNG.")
        if low < 0 or high > 65535:
            raise DataError(
                f"'{name}' holds values from {int(low)} to {int(high)}; save it as 8- or 16-bit"
                " PNG."
            )

    def eight_bits(strip: Image.Image) -> Image.Image:
        values = np.asarray(strip)
        return Image.fromarray(
            (np.rint(values * 255) if floating else values.astype(np.uint32) >> 8).astype(np.uint8)
        )

    return eight_bits
