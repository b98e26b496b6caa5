"""Texts, profiles and EXIF tables of an image cost nothing; its rotation is read within limits."""

import struct
import tracemalloc
import zlib
from contextlib import suppress
from io import BytesIO
from time import process_time
from typing import Any

import numpy as np
import pytest
from PIL import Image

from omnivat.data.bare_files import bare_file, rotation
from omnivat.data.images import VISITORS, read_image
from omnivat.kit.errors import DataError

RGB = np.random.default_rng(3).integers(0, 256, (24, 32, 3), dtype=np.uint8)
SMALL = Image.fromarray(RGB)


def encoded(image: Image.Image, kind: str, **options: Any) -> bytes:
    buffer = BytesIO()
    image.save(buffer, kind, **options)
    return buffer.getvalue()


def chunk(name: bytes, content: bytes) -> bytes:
    check = struct.pack(">I", zlib.crc32(name + content))
    return struct.pack(">I", len(content)) + name + content + check


def in_png(name: bytes, content: bytes) -> bytes:
    """Return a PNG with one more piece in front of its pixels."""
    file = encoded(SMALL, "PNG")
    at = file.index(b"IDAT") - 4
    return file[:at] + chunk(name, content) + file[at:]


def in_jpeg(mark: int, content: bytes, times: int = 1) -> bytes:
    """Return a JPEG with more segments behind its start."""
    file = encoded(SMALL, "JPEG")
    segment = struct.pack(">BBH", 0xFF, mark, len(content) + 2) + content
    return file[:2] + segment * times + file[2:]


def table(entries: int, kind: int, number: int, start: int = 8) -> bytes:
    """Return an EXIF table whose entries all name the same values."""
    body = (struct.pack("<HHII", k + 1, kind, number, start) for k in range(entries))
    return b"II*\0\x08\0\0\0" + struct.pack("<H", entries) + b"".join(body)


def in_tiff(entries: int, number: int) -> bytes:
    """Return a TIFF with more entries, which all name the same bytes."""
    file = encoded(SMALL, "TIFF")
    (at,) = struct.unpack_from("<I", file, 4)
    (many,) = struct.unpack_from("<H", file, at)
    own = file[at + 2 : at + 2 + 12 * many]
    more = b"".join(struct.pack("<HHII", 40_000 + k, 1, number, 8) for k in range(entries))
    body = file + bytes(number) + bytes((len(file) + number) % 2)
    head = struct.pack("<4sI", file[:4], len(body))
    return head + body[8:] + struct.pack("<H", many + entries) + own + more + bytes(4)


COSTLY = {
    "an EXIF table of 20,000 entries in a PNG": in_png(
        b"eXIf", table(20_000, 2, 200_000) + bytes(200_000)
    ),
    "an EXIF table of 5,000 entries in a JPEG": in_jpeg(
        0xE1, b"Exif\0\0" + table(5_000, 10, 500, 100)
    ),
    "300 EXIF parts in a JPEG": in_jpeg(0xE1, b"Exif\0\0" + bytes(65_000), 300),
    "10 MB of fill bytes in a JPEG": encoded(SMALL, "JPEG").replace(
        b"\xff\xd8", b"\xff\xd8" + b"\xff" * 10_000_000, 1
    ),
    "9 million starts of a scan behind a progressive JPEG": encoded(SMALL, "JPEG", progressive=True)
    + b"\xff\xda" * 9_000_000,
    "450 entries of 1 MB in a TIFF": in_tiff(450, 1_000_000),
    "1.2 MB of comments in a GIF": encoded(SMALL, "GIF").replace(
        b"\x2c", b"\x21\xfe" + (b"\xff" + bytes(255)) * 4_900 + b"\0\x2c", 1
    ),
}


@pytest.mark.parametrize("what", COSTLY)
def test_what_is_no_pixel_costs_no_time_and_little_more_memory_than_the_file(what: str) -> None:
    content = COSTLY[what]
    tracemalloc.start()
    began = process_time()
    with suppress(DataError):
        read_image(content, "touch", limits=VISITORS)
    seconds = process_time() - began
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 3 * len(content) + 5_000_000
    assert seconds < 0.4


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "WEBP", "TIFF"])
@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("turn", range(1, 9))
def test_the_rotation_that_is_read_is_the_one_that_pillow_finds(
    kind: str, order: str, turn: int
) -> None:
    exif = Image.Exif()
    exif.endian = order
    exif[0x0112] = turn
    content = encoded(SMALL, kind, exif=exif)
    assert bare_file(content, kind)[1] == turn


@pytest.mark.parametrize(
    "exif",
    [b"", b"II*\0", b"II*\0\xff\xff\xff\xff", b"XX*\0\x08\0\0\0\1\0", table(3, 3, 9), b"\0" * 40],
)
def test_a_damaged_table_turns_nothing(exif: bytes) -> None:
    assert rotation(exif) == 1


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "TIFF"])
def test_a_file_without_notes_is_handed_on_as_it_is_and_with_notes_has_the_same_pixels(
    kind: str,
) -> None:
    noted = {
        "PNG": in_png(b"tEXt", b"k\0" + b"x" * 99),
        "JPEG": in_jpeg(0xE1, b"Exif\0\0" + table(9, 3, 1)),
        "TIFF": in_tiff(9, 40),
    }[kind]
    bare, _ = bare_file(noted, kind)
    plain = encoded(SMALL, kind)
    assert np.array_equal(np.asarray(read_image(noted)), np.asarray(read_image(plain)))
    assert Image.open(BytesIO(bare)).info.get("exif") is None
    if kind != "TIFF":
        assert bare_file(plain, kind)[0] is plain


@pytest.mark.parametrize("size", [(8, 70_000), (70_000, 8)])
def test_a_thread_of_pixels_is_refused_with_its_size(size: tuple[int, int]) -> None:
    with pytest.raises(DataError, match=f"{size[0]} × {size[1]} pixels.*65,535"):
        read_image(encoded(Image.new("1", size), "PNG"), "touch")


def test_an_interlaced_png_of_a_visitor_may_have_half_the_pixels() -> None:
    head = struct.pack(">IIBBBBB", 3_000, 3_000, 16, 6, 0, 0, 1)
    laced = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", b"") + chunk(b"IEND", b"")
    with pytest.raises(DataError, match="read up to 8 megapixels"):
        read_image(laced, "touch", limits=VISITORS)
