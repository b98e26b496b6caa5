"""Read an image of any common kind as upright 8-bit RGB, or raise an error of one sentence.

The same picture gives the same pixels from any file format:

- transparency is blended with white, so hidden colours have no effect;
- 16-bit values keep their upper 8 bits, grey and colour alike; floating values must be in [0, 1];
- a grey picture of more than 8 bits, such as a depth map, whose values between the lowest and the
  highest hundredth span less than a sixteenth of the range is stretched: these two become 0 and
  255; a colour picture that would lose its contrast so is refused;
- the EXIF rotation is applied, colour profiles are not;
- only the first frame of an animation is used;
- a picture with a shorter side over 2,047 pixels, or over 6 megapixels, is reduced by an integer
  factor; encoders use 224 pixels.

Pillow reads the header first; too many pixels are refused then. A file made to cost memory or time
gets both here: the page reads visitors' files in a process that has little of either
(`app/shared/decoder.py`).
"""

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image

from omnivat.data.naming import COMMON, FORMATS, SUFFIXES
from omnivat.kit.errors import DataError
from omnivat.kit.files import read_whole

warnings.filterwarnings("ignore", category=UserWarning, module="PIL")  # of damaged notes in a file

ORIENTATION = 0x0112  # tag of EXIF
HEIC = (b"heic", b"heix", b"heim", b"heis", b"hevc")  # in the first box of such a file
DOUBLE = {b"II": "F;64F", b"MM": "F;64BF"}  # a TIFF of 64-bit floats, by the order of its bytes
MAX_PIXELS = 64_000_000  # checked in the header, before decoding
MAX_JPEG_2000 = 24_000_000  # pixels, of which each takes 20 bytes to decode
MAX_FILE_BYTES = 300_000_000
MOST_SCANS = 100  # of a JPEG; ten are usual, and a hundred of 64 megapixels take 4 s
MIN_SIDE, MAX_SIDE = 8, 65_535  # pixels; JPEG and GIF have no longer side
SHORT_SIDE = 1024  # lower limit of a reduced picture
STRIP_PIXELS = 1_000_000
MOST_PIXELS = 6_000_000  # upper limit of a reduced picture
FLAT = 1 / 16  # share of the range below which a picture of more than 8 bits loses its contrast
REMEDY = "save it as PNG or JPEG and try again"

_MODULES = {
    "JPEG2000": "PIL.Jpeg2KImagePlugin",
    "WEBP": "PIL.WebPImagePlugin",
    "DIB": "PIL.BmpImagePlugin",
    "HEIF": "pillow_heif",
}
UPRIGHT = {  # EXIF orientation -> rotation to upright
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}


VISITORS: dict[str, Any] = {
    "kinds": tuple(COMMON),
    "pixels": 24_000_000,
}  # of uploads, for `opened`


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


def from_array(pixels: Any, name: str) -> Image.Image:
    """Return the picture in an array (H, W), (H, W, C) or (C, H, W) as upright RGB: bytes, 16-bit
    values, floats from 0 to 1, or whole ones to 255. Raises DataError for another array.
    """
    import numpy as np

    if pixels.ndim == 3 and pixels.shape[-1] not in (1, 3, 4):
        pixels = np.moveaxis(pixels, 0, -1)
    if pixels.ndim == 3 and pixels.shape[-1] == 1:
        pixels = pixels[..., 0]
    if pixels.dtype.kind in "iu" and pixels.dtype.itemsize > 2 and pixels.size:  # of a list
        pixels = pixels.astype(np.uint8 if 0 <= pixels.min() <= pixels.max() < 256 else np.int32)
    if pixels.dtype == np.uint16 and pixels.ndim == 3:
        if int(pixels.max()) - int(pixels.min()) < FLAT * 65536:
            raise DataError(_too_flat(name, (int(pixels.max()) >> 8) - (int(pixels.min()) >> 8)))
        pixels = (pixels >> 8).astype(np.uint8)
    if pixels.dtype.kind == "f":
        whole = pixels.size and 1 < pixels.max() <= 255 and pixels.min() >= 0
        if whole and (pixels == np.rint(pixels)).all():
            pixels = pixels.astype(np.uint8)
        elif pixels.ndim == 3 and pixels.size and 0 <= pixels.min() <= pixels.max() <= 1:
            pixels = np.rint(pixels * 255).astype(np.uint8)
        else:
            pixels = pixels.astype(np.float32)
    try:
        return read_image(Image.fromarray(pixels), name, reduced=False)
    except (TypeError, ValueError) as error:
        if isinstance(error, DataError):
            raise
        raise DataError(
            f"'{name}' is {pixels.shape} of {pixels.dtype}; a picture is (H, W), (H, W, 3) or"
            " (3, H, W) of uint8, or of floats from 0 to 1."
        ) from error


def opened(
    content: bytes, name: str, *, kinds: Sequence[str] = tuple(FORMATS), pixels: int = MAX_PIXELS
) -> Image.Image:
    """Return the image in a file's bytes, of which only the header is read.

    kinds   accepted ones
    pixels  most of a kind that cannot be decoded at reduced size, as JPEG can

    `Image.open` would warn about large images, so Pillow's readers are tried in turn.
    Raises DataError as `read_image` does.
    """
    for kind in kinds:
        accepts = _accepts(kind, content, name)
        if accepts:
            break
    else:
        raise DataError(f"'{name}' is not an image of a known kind; {REMEDY}.")
    scans = content.count(b"\xff\xda") if kind == "JPEG" else 0
    if scans > MOST_SCANS + len(content) // 20_000:  # other data holds these two bytes by chance
        raise DataError(f"'{name}' is a JPEG of {scans:,} scans, each decoded in full; {REMEDY}.")
    with _explained(name, f"is a damaged {kind} file"):
        image = Image.OPEN[kind][0](BytesIO(content), "")
    check_size(*image.size, name)
    pixels = min(pixels, MAX_JPEG_2000) if kind == "JPEG2000" else pixels
    if kind != "JPEG" and image.width * image.height > pixels:
        raise DataError(
            f"'{name}' is {image.width} × {image.height} pixels; a {kind} file is read up to "
            f"{pixels / 1e6:.0f} megapixels here. Scale it down, or save it as JPEG."
        )
    return image


def _accepts(kind: str, content: bytes, name: str) -> bool:
    """Load the decoder of a kind of file; return True if the first bytes are of this kind."""
    if kind == "HEIF":
        if content[4:8] != b"ftyp" or not any(brand in content[8:64] for brand in HEIC):
            return False
        try:
            import_module("pillow_heif").register_heif_opener()
        except ImportError as error:
            raise DataError(
                f"'{name}' is a HEIC picture; install pillow-heif, or save it as JPEG."
            ) from error
        return True
    module = import_module(_MODULES.get(kind, f"PIL.{kind.capitalize()}ImagePlugin"))
    if kind == "TIFF":  # Pillow decodes 64-bit floats, and lists no TIFF of them
        for order, raw in DOUBLE.items():
            for white in (0, 1):
                module.OPEN_INFO.setdefault((order, white, (3,), 1, (64,), ()), ("F", raw))
    accepts = Image.OPEN[kind][1]
    named = SUFFIXES.get(Path(name).suffix.lower()) == kind
    return bool(accepts(content[:16].ljust(16, b"\0"))) if accepts else named


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
        if "unknown pixel mode" in str(error):
            what = "holds numbers of a type that is not read"
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
        deep = ";16" in str(getattr(image, "tile", "")) and not image.mode.startswith(
            "I"
        )  # 16-bit colour
        image.load()
        turned = UPRIGHT.get(_turn(image))
        seen = _eight_bit_rgb(image, name, factor(*image.size) if reduced else 1)
    if deep:
        counts = seen.histogram()
        low, high = _middle([sum(counts[level::256]) for level in range(256)])
        if (levels := high - low) < FLAT * 256:
            raise DataError(_too_flat(name, levels))
    return seen if turned is None else seen.transpose(turned)


def _too_flat(name: str, levels: int) -> str:
    return (
        f"'{name}' holds 16-bit colour, of which 8 bits keep {levels} levels; stretch it and save"
        " it as 8-bit PNG."
    )


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

    step, most = max(1, STRIP_PIXELS // image.width), 1.0 if floating else 65535.0
    counts = np.zeros(65536, np.int64)
    for top in range(0, image.height, step):
        values = np.asarray(image.crop((0, top, image.width, min(image.height, top + step))))
        least, highest = float(values.min()), float(values.max())
        if not (least >= 0 and highest <= most):  # also true of NaN
            span = f"values from {least:.9g} to {highest:.9g}, expected 0 to {most:.0f}"
            raise DataError(f"'{name}' holds {span}; save it as 8- or 16-bit PNG.")
        counts += np.bincount((values.ravel() * (65535 / most)).astype(np.int64), minlength=65536)
    low, high = _middle(counts)
    flat = 0 < high - low < FLAT * 65536

    def eight_bits(strip: Image.Image) -> Image.Image:
        values = np.asarray(strip)
        if flat:
            values = ((values * (65535 / most) - low) / (high - low)).clip(0, 1)
        scaled = np.rint(values * 255.0) if flat or floating else values.astype(np.uint32) >> 8
        return Image.fromarray(scaled.astype(np.uint8))

    return eight_bits


def _middle(counts: Any) -> tuple[int, int]:
    """Return the lowest and highest hundredth of values by their counts; if these are one, the
    lowest and highest value.
    """
    import numpy as np

    low, high = np.searchsorted(np.cumsum(counts), np.array([0.01, 0.99]) * np.sum(counts))
    if low == high:
        low, high = np.flatnonzero(counts)[[0, -1]]
    return int(low), int(high)
