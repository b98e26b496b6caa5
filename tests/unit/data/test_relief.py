"""Lamps, slopes and heights: counts, sizes, films, scale, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from omnivat import EXAMPLES, heights, lamps, slopes, with_known_height
from omnivat.data.images import read_image
from omnivat.data.relief import NoLampsError, alone, drawn
from omnivat.data.relief.filters import reduced, resized
from omnivat.kit.errors import DataError
from tests.unit.data.reliefs import LIT, cosine, pressed, shown, touches


def test_three_pictures_give_the_lamps():
    found = lamps(touches(1, 3))
    assert cosine(found.colours, LIT) > 0.98 and found.pictures == 3


def test_lamps_and_slopes_do_not_depend_on_the_pictures_size():
    small, side = touches(1, 3), 331
    large = [np.asarray(Image.fromarray(one).resize((side, side))) for one in small]
    found = lamps(large, dots="keep")
    assert cosine(found.colours, lamps(small, dots="keep").colours) > 0.98
    shrunk = reduced(slopes(large[0], found, dots="keep"), 112)
    shrunk = resized(shrunk, 112, 112)
    assert cosine(shrunk, slopes(small[0], found, dots="keep")) > 0.95


def test_a_film_over_a_dirty_gel_is_read_before_its_median():
    dirt = np.random.default_rng(0).normal(0, 20, (14, 14, 3)).repeat(8, 0).repeat(8, 1)
    film = touches(2, 16, light=128 + dirt)
    found = lamps(film, dots="keep")
    assert found.background is not None and cosine(found.colours, LIT) > 0.97
    clean = shown(sheet := pressed(np.random.default_rng(9)))
    dirty = shown(sheet, light=128 + dirt)
    by_median = slopes(dirty, found, dots="keep")
    assert cosine(by_median, slopes(clean, replace(found, background=None), dots="keep")) > 0.95
    with pytest.raises(DataError, match="224 × 112 pixels, and the lamps' background 112 × 112"):
        slopes(clean.repeat(2, 1), found)


def photographs():
    files = sorted(EXAMPLES.glob("pairs/*/*/*_vis.*"))[::6]
    return [np.asarray(read_image(file)) for file in files]


GREY = [np.repeat(p.mean(-1, keepdims=True).astype(np.uint8), 3, 2) for p in touches(4, 6)]
STILL = np.random.default_rng(5).normal(128, 3, (6, 112, 112, 3)).astype(np.uint8)
OTHER = LIT @ np.array([[0, 1], [-1, 0]])


@pytest.mark.parametrize(
    ("pictures", "reason"),
    [
        ([], "3 pictures of one sensor or more, and there are none; add 3"),
        (touches(0, 1), "there is 1; add 2"),
        (GREY, "grey, or nearly, or photographs"),
        (photographs(), "grey, or nearly, or photographs|not those of a relief"),
        (STILL, "too little contrast: colours vary by [01]"),
        (touches(4, 8) + touches(5, 7, OTHER), "two sensors or more, .*: (8 .* 7|7 .* 8)"),
        ([np.rot90(p, k) for k, p in enumerate(touches(6, 5))], "relief under lamps|not settle"),
    ],
    ids=["none", "one", "grey", "photographs", "faint", "mixed", "turned"],
)
def test_pictures_without_one_gels_lamps_are_refused_with_the_reason(pictures, reason):
    with pytest.raises(NoLampsError, match=reason):
        lamps(pictures)


@pytest.mark.parametrize(
    ("picture", "reason"),
    [
        (np.zeros((90, 90), np.uint8), r"shape \(90, 90\) and type uint8; pass \(height"),
        (np.zeros((90, 90, 3)), "type float64"),
        ([[1, 2], [3]], "type list"),
        (np.zeros((40, 90, 3), np.uint8), "90 × 40 pixels; its relief needs 64 × 64 or more"),
    ],
)
def test_an_array_that_is_no_picture_is_refused(picture, reason):
    with pytest.raises(DataError, match=reason):
        lamps([picture] * 3)


def test_what_are_no_lamps_is_refused():
    with pytest.raises(DataError, match="lamps have type NoneType; pass what"):
        heights(touches(1, 1)[0], None)


def test_a_picture_of_displacements_gives_slopes_as_its_skin_moves_sideways_along_them():
    files = (EXAMPLES / "pairs" / "TQ-T3D-sim").glob("*/*_tac.jpg")
    found = lamps(np.asarray(read_image(file)) for file in files)
    assert found.ratio < 0.4 and cosine(found.colours, np.eye(3, 2) * [-1, 1]) > 0.9


def test_heights_are_in_millimetres_by_one_known_height():
    y, x = np.mgrid[:224, :224] - 112.0
    ball = np.sqrt(np.maximum(20.0**2 - x**2 - y**2, 0)) * 0.4
    pictures = [
        shown(np.roll(ball, (k, -k), (0, 1)) + 4 * pressed(np.random.default_rng(k), 224, 224))
        for k in range(5)
    ]
    found, touch = lamps(pictures, dots="keep"), shown(ball)
    with pytest.raises(DataError, match="one known height"):  # before the picture is looked at
        heights(None, found, pixel=0.05)
    known = with_known_height(found, touch, pixel=0.05, height=0.4)
    millimetres = heights(touch, known, pixel=0.05, dots="keep")
    assert millimetres.dtype == np.float32
    assert abs(np.median(millimetres)) < 1e-9  # of an even count it is a mean, and rounded
    assert np.quantile(millimetres, 0.999) == pytest.approx(0.4, rel=1e-4)
    assert np.corrcoef(millimetres.ravel(), ball.ravel())[0, 1] > 0.9
    larger = heights(touch.repeat(2, 0).repeat(2, 1), known, pixel=0.025, dots="keep")
    assert larger.max() == pytest.approx(millimetres.max(), rel=0.05)


def test_a_drawn_relief_is_mid_grey_where_the_gel_is_flat():
    found = lamps(touches(1, 5))
    flat = drawn(np.full((96, 130, 3), 90, np.uint8), found)
    assert flat.shape == (96, 130, 3) and (flat == 128).all()


def test_one_relief_is_drawn_alike_under_two_gels_even_by_a_picture_alone():
    sheet, other = pressed(np.random.default_rng(5)), LIT[[1, 2, 0]] @ [[0.8, -0.6], [0.6, 0.8]]
    pair = [drawn(shown(sheet, lit)).astype(float).ravel() for lit in (LIT, other)]
    assert np.corrcoef(pair)[0, 1] > 0.95
    by_lamps = drawn(shown(sheet), lamps(touches(1, 5))).astype(float).ravel()
    assert np.corrcoef(by_lamps, pair[1])[0, 1] > 0.9


@pytest.mark.parametrize(
    "odd",
    [None, np.eye(2), np.eye(3, 2) > 0, *(np.full((3, 2), x) for x in (np.nan, 1e308, 1e-320))],
)
def test_lamps_have_numbers_for_three_colours(odd):
    found = lamps(touches(1, 3))
    with pytest.raises(DataError, match=r"3 × 2 numbers, the largest from .* again\.$"):
        replace(found, colours=odd)


def test_an_even_touch_alone_has_no_light_of_lamps_and_no_relief():
    even = np.full((64, 64, 3), 128, np.uint8)
    assert not alone(even).colours.any() and len(np.unique(drawn(even))) == 1


@pytest.mark.parametrize("odd", ["x", 0, np.nan, 10**400])
def test_only_numbers_above_0_give_a_scale(odd):
    found, picture = lamps(touches(1, 3)), touches(1, 1)[0]
    for pixel, height in ((odd, 1.0), (0.1, odd)):
        with pytest.raises(DataError, match=r"numbers above 0\.$"):
            with_known_height(found, picture, pixel=pixel, height=height)
    known = with_known_height(found, picture, pixel=0.1, height=1.0)
    with pytest.raises(DataError, match=r"give a number above 0\.$"):
        heights(picture, known, pixel=odd)
