"""Large pictures: reduced by a whole factor, in strips, within a visitor's limits."""

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from omnivat.data.images import VISITORS, draft_scale, factor, read_image
from omnivat.kit.errors import DataError


def encoded(image, kind, **options):
    buffer = BytesIO()
    image.save(buffer, kind, **options)
    return buffer.getvalue()


def test_rare_kinds_are_for_a_person_and_not_for_visitors():
    for kind in ("JPEG2000", "AVIF"):
        content = encoded(Image.new("RGB", (64, 64)), kind)
        assert read_image(content).size == (64, 64)
        with pytest.raises(DataError, match="not an image of a known kind"):
            read_image(content, limits=VISITORS)


@pytest.mark.parametrize("size", [(8, 70_000), (70_000, 8)])
def test_a_thread_of_pixels_is_refused_with_its_size(size):
    with pytest.raises(DataError, match=f"{size[0]} × {size[1]} pixels.*65,535"):
        read_image(encoded(Image.new("1", size), "PNG"), "touch")


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
