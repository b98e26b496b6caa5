"""What a header says before anything is decoded, and hostile files refused by it."""

import struct
import zlib
from io import BytesIO
from time import process_time
from typing import Any

import numpy as np
import pytest
from PIL import Image

from omnivat.data.image_files import OddFileError, image_file
from omnivat.data.images import OWN, VISITORS, draft_scale, factor, read_image
from omnivat.kit.errors import DataError

KINDS = ["PNG", "JPEG", "WEBP", "GIF", "BMP", "TIFF"]


def encoded(image: Image.Image, kind: str, **options: Any) -> bytes:
    buffer = BytesIO()
    image.save(buffer, kind, **options)
    return buffer.getvalue()


def chunk(name: bytes, content: bytes = b"") -> bytes:
    check = struct.pack(">I", zlib.crc32(name + content))
    return struct.pack(">I", len(content)) + name + content + check


def png(width: int, height: int, colour: int = 2, depth: int = 8, extra: bytes = b"") -> bytes:
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0))
    body = chunk(b"IDAT", zlib.compress(b"\0" * 99)) + chunk(b"IEND")
    return b"\x89PNG\r\n\x1a\n" + header + extra + body


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("mode", ["RGB", "L"])
def test_the_header_says_the_size_that_the_decoder_finds(kind, mode):
    found = image_file(encoded(Image.new(mode, (37, 21)), kind))
    assert found is not None
    assert (found.kind, found.width, found.height) == (kind, 37, 21)


@pytest.mark.parametrize("kind", KINDS)
def test_the_estimate_is_never_below_what_the_decoded_picture_holds(kind):
    for mode in ("RGB", "L", "P", "1", "RGBA", "CMYK", "I;16"):
        try:
            content = encoded(Image.new(mode, (64, 64)), kind)
        except (OSError, ValueError):
            continue  # this kind has no such mode
        found, opened = image_file(content), Image.open(BytesIO(content))
        held = {"1": 1, "L": 1, "P": 1, "I;16": 2}.get(opened.mode, 4)
        assert found is not None
        assert found.cost() >= held * 64 * 64, mode


def webp_lossless(side: int) -> bytes:
    """Return a header of a lossless WebP with alpha; 34 bytes make a picture of any size."""
    packed = (side - 1) | (side - 1) << 14 | 1 << 28
    body = b"\x2f" + struct.pack("<I", packed) + b"\0" * 9
    chunked = b"VP8L" + struct.pack("<I", len(body)) + body
    return b"RIFF" + struct.pack("<I", 4 + len(chunked)) + b"WEBP" + chunked


HOSTILE = {
    "a WebP of 34 bytes and 64 megapixels": webp_lossless(8000),
    "a PNG of 48 megapixels in colour": png(8000, 6000),
    "a million empty pieces in a PNG": png(64, 64, extra=chunk(b"tIME") * 1_000_000),
    "a PNG with a hundred compressed texts": png(
        64, 64, extra=chunk(b"zTXt", b"a\0\0" + zlib.compress(b"x" * 1_000_000)) * 100
    ),
    "a JPEG of a million comments": b"\xff\xd8" + b"\xff\xfe\x00\x02" * 1_000_000,
    "a JPEG of ten million fill bytes": b"\xff\xd8" + b"\xff" * 10_000_000,
    "a JPEG of five thousand scans": encoded(
        Image.new("RGB", (64, 64)), "JPEG", progressive=True
    ).replace(b"\xff\xd9", b"") + b"\xff\xda\x00\x08\x01\x01\x00\x00\x3f\x00\x00" * 5000,
    "a GIF with a million blocks": b"GIF89a" + struct.pack("<HHBBB", 64, 64, 0, 0, 0)
    + b"\x21\xfe" + b"\x01x" * 1_000_000 + b"\0\x2c",
    "a BMP in run lengths": b"BM" + b"\0" * 12
    + struct.pack("<IiiHHIIiiII", 40, 4000, 4000, 1, 8, 1, 0, 0, 0, 0, 0),
    "a TIFF table of 60,000 entries": b"II*\0" + struct.pack("<IH", 8, 60_000) + b"\0" * 999,
    "a TIFF with a huge tile": b"II*\0" + struct.pack("<IH", 8, 5)
    + b"".join(struct.pack("<HHII", tag, 4, 1, value)
               for tag, value in ((256, 64), (257, 64), (259, 5), (322, 65_536), (323, 65_536))),
    "a PPM with a comment of 19 MB": b"P6\n#" + b"x" * 19_000_000 + b"\n64 64 255\n",
    "a JPEG 2000": encoded(Image.new("RGB", (64, 64)), "JPEG2000"),
    "an AVIF": encoded(Image.new("RGB", (64, 64)), "AVIF"),
    "a header cut short": b"\x89PNG\r\n\x1a\n",
}  # fmt: skip


@pytest.mark.parametrize("what", HOSTILE)
def test_a_hostile_file_of_a_visitor_is_refused_by_its_header_at_once(what):
    began = process_time()
    with pytest.raises(DataError, match=r"'touch.png' (is|has|holds)"):
        read_image(HOSTILE[what], name="touch.png", limits=VISITORS)
    assert process_time() - began < 1


def test_a_person_may_read_rare_kinds_of_their_own():
    for what in ("a JPEG 2000", "an AVIF"):
        assert read_image(HOSTILE[what], limits=OWN).size == (64, 64)


def test_a_comment_that_hides_the_header_is_refused_for_everybody():
    with pytest.raises(DataError, match="no header in its first 4096 bytes"):
        read_image(HOSTILE["a PPM with a comment of 19 MB"], limits=OWN)


def test_a_photo_of_50_megapixels_is_read_reduced_within_a_visitors_limits():
    content = encoded(Image.new("RGB", (8160, 6120), (10, 120, 200)), "JPEG", quality=30)
    image = read_image(content, limits=VISITORS)
    assert image.size == (2040, 1530)
    assert np.allclose(np.asarray(image)[::500, ::500], (10, 120, 200), atol=6)


@pytest.mark.slow
def test_a_large_picture_is_made_smaller_by_a_whole_factor_like_its_mean():
    random = np.random.default_rng(3)
    pixels = random.integers(0, 256, (2048, 2100, 3), dtype=np.uint8)
    read = np.asarray(read_image(encoded(Image.fromarray(pixels), "PNG", compress_level=1)))
    wanted = pixels.reshape(1024, 2, 1050, 2, 3).mean((1, 3))
    assert read.shape == wanted.shape
    assert np.abs(read - wanted).max() <= 1


def test_every_pixel_is_kept_where_asked_for_and_below_2048():
    image = Image.new("L", (2048, 2048))
    assert read_image(image, reduced=False).size == (2048, 2048)
    assert read_image(Image.new("L", (2047, 2900))).size == (2047, 2900)


def test_the_strips_of_a_picture_with_a_palette_and_transparency_join_without_a_seam():
    image = Image.new("P", (2100, 2050), 1)
    image.putpalette([10, 20, 30, 200, 100, 50])
    read = np.asarray(read_image(encoded(image, "PNG", transparency=0)))
    assert (read == (200, 100, 50)).all()


@pytest.mark.parametrize(
    ("size", "wanted"), [((3000, 4000), 2), ((8160, 6120), 4), ((640, 480), 1)]
)
def test_a_jpeg_is_decoded_no_smaller_than_the_factor_asks(size, wanted):
    assert draft_scale(*size) == wanted <= factor(*size)


def test_random_damage_to_a_header_is_refused_as_odd_or_read_and_nothing_else():
    random = np.random.default_rng(11)
    for kind in KINDS:
        content = encoded(Image.new("RGB", (40, 30), "red"), kind)
        for _ in range(300):
            damaged = bytearray(content)
            for place in random.integers(0, min(len(damaged), 200), 3):
                damaged[place] = random.integers(0, 256)
            try:
                image_file(bytes(damaged))
            except OddFileError:
                continue
