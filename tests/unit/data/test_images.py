"""All kinds of image files: read correctly, or refused in one sentence."""

import re
import struct
import sys
import zlib
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from omnivat.data.images import VISITORS, central_square, opened, read_image, upright
from omnivat.data.naming import COMMON, FORMATS, is_image_name
from omnivat.kit.errors import DataError

RANDOM = np.random.default_rng(7)
RGB = RANDOM.integers(0, 256, (24, 32, 3), dtype=np.uint8)
GREY = RGB[..., 0].copy()


def encoded(image, kind="PNG", **options):
    buffer = BytesIO()
    image.save(buffer, kind, **options)
    return buffer.getvalue()


def values(source):
    image = read_image(source)
    assert image.mode == "RGB"
    return np.asarray(image)


def refusal(source, name="touch.png"):
    with pytest.raises(DataError) as caught:
        read_image(source, name=name)
    sentence = str(caught.value)
    assert name in sentence
    assert "\n" not in sentence
    return sentence


LOSSLESS = {"WEBP": {"lossless": True}, "JPEG2000": {"irreversible": False}}


@pytest.mark.parametrize("kind", ["PNG", "BMP", "TIFF", "PPM", "QOI", "TGA", "DIB", *LOSSLESS])
def test_the_same_pixels_come_out_of_every_lossless_file(kind, tmp_path):
    file = tmp_path / f"a.{FORMATS[kind].split()[0]}"
    file.write_bytes(encoded(Image.fromarray(RGB), kind, **LOSSLESS.get(kind, {})))
    assert np.array_equal(values(file), RGB)


def test_documents_listing_page_and_decoder_share_one_table_of_formats(tmp_path):
    suffixes = [suffix for all in FORMATS.values() for suffix in all.split()]
    root = Path(__file__).parents[3]
    listed = re.search(r"vis\.png +([a-z0-9 ]+), upper", (root / "docs/data.md").read_text("utf-8"))
    assert listed and listed[1].split() == suffixes
    script = (root / "app/web/pair/pairing.js").read_text("utf-8")
    common = [suffix for all in COMMON.values() for suffix in all.split()]
    assert re.search(r"PICTURE = /\\\.\((.*)\)\$/i", script)[1].split("|") == common
    for kind, all in FORMATS.items():
        if kind == "HEIF":
            continue
        for suffix in all.split():
            file = tmp_path / f"a.{suffix}"
            file.write_bytes(encoded(Image.fromarray(RGB), kind))
            assert is_image_name(file.name) and read_image(file).size == (32, 24), suffix


def test_heic_is_read_where_its_decoder_is_installed_and_else_explained(tmp_path, monkeypatch):
    content = b"\0\0\0\x18ftypheic\0\0\0\0mif1heic"
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "pillow_heif", None)
        assert "install pillow-heif, or save it as JPEG" in refusal(content, "a.heic")
    heif = pytest.importorskip("pillow_heif")
    heif.from_pillow(Image.fromarray(np.full((48, 64, 3), (200, 40, 40), np.uint8))).save(
        tmp_path / "a.heic"
    )
    assert np.allclose(values(tmp_path / "a.heic"), (200, 40, 40), atol=8)


@pytest.mark.parametrize("low", [300, 30_000])
def test_a_deep_picture_that_would_lose_its_contrast_is_stretched_or_refused(low):
    ramp = np.linspace(low, low + 400, 64 * 64).reshape(64, 64)
    deep = ramp.astype(np.uint16)
    deep[0, 0] = 0  # a hole of a depth camera: under a hundredth of the pixels
    read = values(encoded(Image.fromarray(deep), "TIFF"))[..., 0]
    assert read.min() == 0 and read.max() == 255 and len(np.unique(read)) > 200
    unit = values(encoded(Image.fromarray((ramp / 65535).astype(np.float32)), "TIFF"))[..., 0]
    assert np.abs(unit.astype(int) - read)[1:].max() <= 1
    body = b"".join(b"\0" + row.tobytes() for row in np.repeat(deep, 3, 1).astype(">u2"))
    assert "16-bit colour, of which 8 bits keep" in refusal(png((64, 64), 2, 16, body))


def test_a_tiff_of_numbers_of_another_type_is_named():
    content = encoded(Image.fromarray((GREY / 255).astype(np.float32)), "TIFF")
    bits = [struct.pack("<HHIHH", 258, 3, 1, count, 0) for count in (32, 16)]
    assert content.count(bits[0]) == 1
    assert "numbers of a type that is not read" in refusal(content.replace(*bits))


def png(size, mode, depth, body):
    """Return a PNG of kinds that Pillow does not write. size: width, height."""

    def block(name, content):
        check = struct.pack(">I", zlib.crc32(name + content))
        return struct.pack(">I", len(content)) + name + content + check

    header = struct.pack(">IIBBBBB", *size, depth, mode, 0, 0, 0)
    blocks = block(b"IHDR", header) + block(b"IDAT", zlib.compress(body)) + block(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + blocks


@pytest.mark.parametrize("mode", ["L", "1", "P", "CMYK", "YCbCr", "LA", "RGBA"])
def test_each_mode_gives_what_its_conversion_says(mode):
    image = Image.fromarray(RGB).convert(mode)
    source = image if mode == "YCbCr" else encoded(image, "TIFF" if mode == "CMYK" else "PNG")
    assert np.array_equal(values(source), np.asarray(image.convert("RGB")))


def test_colours_hidden_under_full_transparency_do_not_matter():
    alpha = np.zeros(GREY.shape, np.uint8)
    alpha[:, 16:] = 255
    seen = []
    for hidden in (0, 255):
        pixels = np.dstack([RGB, alpha])
        pixels[:, :16, :3] = hidden
        seen.append(values(encoded(Image.fromarray(pixels, "RGBA"))))
    assert np.array_equal(seen[0], seen[1])
    assert (seen[0][:, :16] == 255).all()
    assert np.array_equal(seen[0][:, 16:], RGB[:, 16:])


def test_the_exif_rotation_is_applied():
    exif = Image.Exif()
    exif[0x0112] = 6
    read = values(encoded(Image.fromarray(RGB), exif=exif))
    assert np.array_equal(read, np.rot90(RGB, -1))


def test_damaged_exif_leaves_the_image_as_it_is_stored():
    content = encoded(Image.fromarray(RGB), exif=b"Exif\0\0II*\0\xff\xff\xff\xff")
    assert np.array_equal(values(content), RGB)


@pytest.mark.parametrize("kind", ["GIF", "TIFF"])
def test_the_first_frame_of_an_animation_is_taken(kind):
    first, other = (Image.new("RGB", (16, 16), colour) for colour in ("red", "blue"))
    content = encoded(first, kind, save_all=True, append_images=[other])
    assert (values(content) == (255, 0, 0)).all()


def floating(value):
    wrong = np.zeros((16, 16), np.float32)
    wrong[3, 3] = value
    return encoded(Image.fromarray(wrong), "TIFF")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "0 bytes"),
        *(
            (text, "PNG or JPEG")
            for text in (b"hello, no image", b"\0" * 64, b"%!PS EPSF", b"<svg/>")
        ),
        (encoded(Image.new("RGB", (1, 1))), "1 × 1"),
        *((encoded(Image.new("1", size)), "65,535") for size in ((8, 70_000), (70_000, 8))),
        # Pillow itself warns of the second and raises for the third; neither may show
        *((png((n, n), 2, 8, b"\0" * 99), f"{n} × {n}") for n in (9_000, 10_000, 60_000)),
        (encoded(Image.fromarray(np.full((16, 16), 1_000_000, np.int32)), "TIFF"), "1000000"),
        *((floating(value), "0 to 1") for value in (2.0, -0.5, np.nan, np.inf)),
    ],
)
def test_what_is_no_picture_of_known_values_and_size_is_refused(content, words):
    assert words in refusal(content)


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "BMP", "TIFF", "WEBP", "QOI", "PPM", "JPEG2000"])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.9])
def test_a_file_that_is_cut_short_is_refused(kind, share):
    content = encoded(Image.fromarray(RANDOM.integers(0, 256, (64, 64, 3), dtype=np.uint8)), kind)
    sentence = refusal(content[: max(1, int(len(content) * share))])
    assert "PNG or JPEG" in sentence or "pixels" in sentence


def test_a_missing_file_and_a_folder_are_refused_by_name(tmp_path):
    for path in (tmp_path / "none.png", tmp_path):
        with pytest.raises(DataError, match="cannot be read") as caught:
            read_image(path)
        assert str(path) in str(caught.value)


def test_the_central_square_is_cut_and_never_grows():
    image = Image.fromarray(RGB)
    assert np.array_equal(np.asarray(central_square(image, 10)), RGB[7:17, 11:21])
    assert central_square(image, 999).size == (24, 24)
    assert central_square(image, 0).size == image.size


# Large pictures: reduced by a whole factor, in strips, within a visitor's limits.


def test_rare_kinds_are_for_a_person_and_not_for_visitors():
    for kind in ("JPEG2000", "AVIF"):
        content = encoded(Image.new("RGB", (64, 64)), kind)
        assert read_image(content).size == (64, 64)
        with pytest.raises(DataError, match="not an image of a known kind"):
            opened(content, "a", **VISITORS)


def test_a_jpeg_2000_that_would_take_a_gigabyte_is_refused_by_its_header():
    content = encoded(Image.new("RGB", (64, 64)), "JPEG2000")
    size = content.index(b"ihdr") + 4
    with pytest.raises(DataError, match="a JPEG2000 file is read up to 24 megapixels here"):
        opened(content[:size] + struct.pack(">II", 5000, 5000) + content[size + 8 :], "a")


def test_a_photo_of_50_megapixels_is_read_reduced_within_a_visitors_limits():
    content = encoded(Image.new("RGB", (8160, 6120), (10, 120, 200)), "JPEG", quality=30)
    image = upright(opened(content, "a", **VISITORS), "a")
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


@pytest.mark.parametrize("kind", ["PNG", "TIFF"])
def test_sixteen_bits_of_grey_keep_their_upper_eight(kind):
    wide = GREY.astype(np.uint16) * 256 + 77
    read = values(encoded(Image.fromarray(wide), kind))
    assert np.array_equal(read, np.repeat(GREY[..., None], 3, axis=2))


def test_a_jpeg_of_thousands_of_scans_is_refused_before_they_are_decoded():
    with BytesIO() as file:
        Image.new("L", (64, 64), 128).save(file, "JPEG", progressive=True)
        content = file.getvalue()
    assert read_image(content).size == (64, 64)
    last = content[content.rindex(b"\xff\xda") : -2]
    with pytest.raises(DataError, match=r"is a JPEG of 1,0\d\d scans"):
        read_image(content[:-2] + 1000 * last + content[-2:])
