"""Image files with a decoding cost far above their size."""

import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from time import monotonic
from typing import Any

import numpy as np
from PIL import Image

MOST_S = 10.0  # seconds for one file; its processor time and memory are limits of its process


def costly() -> dict[str, bytes]:
    """Return files of at most 20 MB by name: the largest accepted ones, and larger ones."""
    random = np.random.default_rng(0)
    noise = Image.fromarray(random.integers(0, 256, (1990, 2000, 3), dtype=np.uint8))
    slope = np.add.outer(np.arange(3400), np.arange(3600)).astype(np.uint8)
    soft = Image.fromarray(np.stack([slope, slope[::-1], slope[:, ::-1]], -1))
    plain = Image.new
    return {
        "WebP, 34 bytes, 64 megapixels": encoded(
            plain("RGBA", (8000, 8000)), "WEBP", lossless=True
        ),
        "WebP, noise": encoded(noise, "WEBP", quality=100, method=0),
        "WebP, lossless noise": encoded(noise, "WEBP", lossless=True, method=0, quality=0),
        "JPEG, progressive noise": encoded(noise.resize((3200, 2800)), "JPEG", progressive=True),
        "JPEG, 64 megapixels": encoded(plain("RGB", (8000, 8000), 1), "JPEG"),
        "JPEG, 64 megapixels, progressive": encoded(
            plain("RGB", (8000, 8000), 1), "JPEG", progressive=True
        ),
        "JPEG, CMYK": encoded(plain("CMYK", (7000, 7000), 1), "JPEG"),
        "PNG, soft": encoded(soft, "PNG", compress_level=1),
        "PNG, transparent": encoded(plain("RGBA", (3500, 3500), (1, 2, 3, 4)), "PNG"),
        "PNG, 16 bits grey": encoded(Image.fromarray(np.zeros((4890, 4890), np.uint16)), "PNG"),
        "PNG, interlaced, 16 bits RGBA": interlaced(2820, 2820),
        "TIFF, deflate": encoded(soft, "TIFF", compression="tiff_adobe_deflate"),
        "TIFF, LZW": encoded(noise, "TIFF", compression="tiff_lzw"),
        "TIFF, floating": encoded(
            Image.fromarray(np.zeros((3500, 3500), np.float32)), "TIFF", compression="tiff_lzw"
        ),
        "GIF": encoded(plain("P", (4000, 4000), 1), "GIF"),
        "BMP": encoded(soft.resize((2500, 2600)), "BMP"),
        "JPEG 2000": encoded(plain("RGB", (4000, 4000)), "JPEG2000"),
        "PPM, a comment of 19 MB": b"P6\n#" + b"x" * 19_000_000 + b"\n9 9\n255\n" + bytes(243),
        **_noted(),
    }


def _noted() -> dict[str, bytes]:
    """Return small pictures with large notes: EXIF tables, comments, fill bytes."""
    small = Image.new("RGB", (600, 600), 5)
    jpeg, png = encoded(small, "JPEG"), encoded(small, "PNG")
    gif = encoded(small.convert("P"), "GIF")
    entries = b"".join(struct.pack("<HHII", k, 2, 200_000, 8) for k in range(65_000))
    table = b"II*\0\x08\0\0\0" + struct.pack("<H", 65_000) + entries + bytes(200_000)
    at = png.index(b"IDAT") - 4
    part = b"\xff\xe1" + struct.pack(">H", 65_008) + b"Exif\0\0" + bytes(65_000)
    return {
        "PNG, 1 MB of EXIF entries": png[:at] + chunk(b"eXIf", table) + png[at:],
        "JPEG, 300 EXIF parts": jpeg[:2] + part * 300 + jpeg[2:],
        "JPEG, 19 MB of fill bytes": jpeg[:2] + b"\xff" * 19_000_000 + jpeg[2:],
        "JPEG, 9 million starts of a scan": encoded(small, "JPEG", progressive=True)
        + b"\xff\xda" * 9_000_000,
        "GIF, 1.2 MB of comments": gif.replace(
            b"\x2c", b"\x21\xfe" + (b"\xff" + bytes(255)) * 4_900 + b"\0\x2c", 1
        ),
        "PNG, 8 x 1.9 million": encoded(Image.new("RGBA", (8, 1_900_000)), "PNG"),
    }


def chunk(name: bytes, body: bytes) -> bytes:
    """Return a part of a PNG."""
    return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))


def encoded(image: Image.Image, kind: str, **options: Any) -> bytes:
    """Return a picture as a file."""
    with BytesIO() as handle:
        image.save(handle, kind, **options)
        return handle.getvalue()


def interlaced(width: int, height: int) -> bytes:
    """Return a PNG of one colour, 16 bits RGBA, in the seven passes of Adam7."""
    passes = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4))
    packer, parts = zlib.compressobj(6), []
    for left, top, across, down in (*passes, (1, 0, 2, 2), (0, 1, 1, 2)):
        row = b"\4" + bytes([7]) * (8 * -(-(width - left) // across))
        parts += [packer.compress(row) for _ in range(-(-(height - top) // down))]
    head = struct.pack(">IIBBBBB", width, height, 16, 6, 0, 0, 1)
    chunks = ((b"IHDR", head), (b"IDAT", b"".join(parts) + packer.flush()), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(name, body) for name, body in chunks)


def decoded(decoder: Any) -> Iterator[tuple[str, bool]]:
    """Yield the name of each costly file, and True if the decoder read or refused the file within
    MOST_S and then read a plain picture.
    """
    from omnivat.kit.errors import DataError

    def ends(content: bytes) -> bool:
        began = monotonic()
        try:
            decoder.read(content, "x")
        except DataError as error:
            return str(error).endswith(".") and monotonic() - began < MOST_S
        return monotonic() - began < MOST_S

    plain = encoded(Image.new("RGB", (99, 99)), "PNG")
    for name, content in costly().items():
        yield name, ends(content) and decoder.read(plain, "plain").width == 99
