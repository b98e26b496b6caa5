"""Dots printed on a gel are filled; every other picture comes back as it is."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from scipy.ndimage import gaussian_filter, zoom

from omnivat.data.dots import fill_dots
from omnivat.simulate.domains import SIMULATED
from omnivat.simulate.drawing import tactile
from omnivat.simulate.plan import planned
from omnivat.simulate.things import thing

SIDE = 224


def gel(side: int = SIDE, seed: int = 0, grain: float = 4.0) -> np.ndarray:
    """A lit gel (side, side, 3), 0 to 255: slow changes of colour, and grain."""
    random = np.random.default_rng(seed)
    slow = zoom(random.uniform(90, 200, (4, 4, 3)), (side / 4, side / 4, 1), order=1)
    return slow[:side, :side] + random.normal(0, grain, (side, side, 3))


def picture(values: np.ndarray) -> np.ndarray:
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


def printed(  # (side, side): share of light that dots take
    side: int = SIDE,
    pitch: float = 26.0,
    radius: float = 4.5,
    *,
    square: bool = False,
    turn: float = 0.0,
    missing: float = 0.0,
    bulge: float = 0.0,
    darkness: float = 0.8,
    seed: int = 0,
) -> np.ndarray:
    random = np.random.default_rng(seed)
    y, x = np.mgrid[:side, :side] - side / 2
    pushed = 1 - bulge * np.exp(-(x**2 + y**2) / (2 * (side / 5) ** 2))
    u = pushed * (x * np.cos(turn) + y * np.sin(turn)) + pitch / 3
    v = pushed * (y * np.cos(turn) - x * np.sin(turn)) + pitch / 4
    i, j = np.round(u / pitch).astype(int), np.round(v / pitch).astype(int)
    du, dv = u - i * pitch, v - j * pitch
    away = np.maximum(np.abs(du), np.abs(dv)) if square else np.hypot(du, dv)
    there = random.random((99, 99)) >= missing
    return darkness * np.clip(radius + 0.5 - away, 0, 1) * there[i + 49, j + 49]


def with_dots(clean: np.ndarray, shade: np.ndarray) -> np.ndarray:
    return picture(clean * (1 - shade[..., None]))


@settings(max_examples=20)
@given(
    pitch=st.floats(16, 40),
    share=st.floats(0.12, 0.2),
    turn=st.floats(-0.12, 0.12),
    darkness=st.floats(0.35, 0.95),
    square=st.booleans(),
    seed=st.integers(0, 99),
)
def test_a_printed_grid_is_found_and_filled_near_the_gel_below(
    pitch: float, share: float, turn: float, darkness: float, square: bool, seed: int
) -> None:
    clean = gel(seed=seed)
    shade = printed(pitch=pitch, radius=share * pitch, turn=turn, darkness=darkness, square=square)
    filled, dots = fill_dots(with_dots(clean, shade))
    assert dots is not None and not dots.light
    assert np.abs(np.array(dots.pitch) - pitch).max() <= 1.5
    below = shade > 0.1
    # grain alone: 4 × 2 / √π, and clipping
    assert np.abs(filled.astype(float) - clean)[below].mean() < 9


@pytest.mark.parametrize("side", [224, 337, 480, 1080])
def test_dots_are_filled_at_every_size_of_a_picture(side: int) -> None:
    clean = gel(side)
    shade = printed(side, pitch=side / 9, radius=side / 60)
    filled, dots = fill_dots(with_dots(clean, shade))
    assert dots is not None and dots.number >= 70
    assert np.abs(filled.astype(float) - clean)[shade > 0.1].mean() < 9


def test_a_wide_picture_is_filled_too() -> None:
    wide = np.concatenate([gel(), gel(seed=1)[:, :80]], 1)
    y, x = np.mgrid[:224, :304]
    shade = 0.8 * (np.hypot(x % 26 - 13, y % 26 - 13) < 4.5)
    assert (dots := fill_dots(with_dots(wide, shade))[1]) and dots.number >= 80


def test_missing_dots_and_a_press_leave_the_rest_of_the_grid_filled() -> None:
    clean = gel()
    shade = printed(missing=0.1, bulge=0.12)
    filled, dots = fill_dots(with_dots(clean, shade))
    assert dots is not None and dots.share < 1
    covered = (filled != with_dots(clean, shade)).any(2)
    assert covered[shade > 0.4].mean() > 0.97


def test_light_dots_on_a_dark_gel_are_filled() -> None:
    clean = gel() / 3
    shade = printed()
    filled, dots = fill_dots(picture(clean + (235 - clean) * shade[..., None]))
    assert dots is not None and dots.light
    assert np.abs(filled.astype(float) - clean)[shade > 0.1].mean() < 9


def test_what_is_not_a_dot_keeps_its_bytes() -> None:
    marked = with_dots(gel(), shade := printed())
    filled, _ = fill_dots(marked)
    far = gaussian_filter((shade > 0).astype(float), 3) < 0.01
    assert far.any() and (filled[far] == marked[far]).all()
    assert filled is not marked and marked.flags.writeable  # the picture given stays


def test_the_second_fill_finds_nothing() -> None:
    once, dots = fill_dots(with_dots(gel(), printed()))
    assert dots is not None
    again, none = fill_dots(once)
    assert none is None and again is once


def specks(seed: int) -> np.ndarray:
    random, shade = np.random.default_rng(seed), np.zeros((SIDE, SIDE))
    y, x = np.mgrid[:SIDE, :SIDE]
    for u, v, r in zip(*random.uniform(0, SIDE, (2, 90)), random.uniform(2, 6, 90), strict=True):
        shade = np.maximum(shade, 0.8 * np.clip(r - np.hypot(x - u, y - v), 0, 1))
    return shade


def grain_of_a_grey_frame(seed: int) -> np.ndarray:
    noise = gaussian_filter(np.random.default_rng(seed).normal(size=(SIDE, SIDE)), 2.5)
    return np.repeat((150 + 300 * noise)[..., None], 3, 2)


def letters(_: int) -> np.ndarray:
    from PIL import ImageDraw

    page = Image.new("L", (SIDE, SIDE), 190)
    for line in range(14):
        ImageDraw.Draw(page).text((6, 16 * line), "the quick brown fox jumps over the dog", fill=40)
    return np.repeat(np.asarray(page, float)[..., None], 3, 2)


def stripes(seed: int) -> np.ndarray:
    y, x = np.mgrid[:SIDE, :SIDE]
    return gel(seed=seed) * (1 - 0.5 * (np.sin((x + 0.2 * y) / 3) > 0.6))[..., None]


def weave(seed: int) -> np.ndarray:
    y, x = np.mgrid[:SIDE, :SIDE]
    return gel(seed=seed) * (0.75 + 0.25 * np.sin(x / 2.2) * np.sin(y / 2.2))[..., None]


def knurl(seed: int) -> np.ndarray:  # lit relief in a grid: each side has its own colour
    y, x = np.mgrid[:SIDE, :SIDE]
    slopes = [
        np.cos(x / 3.5) * np.sin(y / 3.5),
        np.sin(x / 3.5) * np.cos(y / 3.5),
        -np.cos(x / 3.5) * np.sin(y / 3.5),
    ]
    return gel(seed=seed) + 70 * np.stack(slopes, -1)


def shell(_: int) -> np.ndarray:
    y, x = np.mgrid[:SIDE, :SIDE]
    return np.repeat((140 + 50 * np.sin(np.hypot(x - 60, y - 240) / 3))[..., None], 3, 2)


def one_row_of_holes(seed: int) -> np.ndarray:
    shade = printed(seed=seed)
    shade[:90] = shade[130:] = 0
    return gel(seed=seed) * (1 - shade[..., None])


def dots_in_one_corner(seed: int) -> np.ndarray:
    shade = printed(pitch=20, radius=3)
    shade[110:] = shade[:, 110:] = 0
    return gel(seed=seed) * (1 - shade[..., None])


def checkers(_: int) -> np.ndarray:
    y, x = np.mgrid[:SIDE, :SIDE]
    return np.repeat(np.where((x // 14 + y // 14) % 2, 60.0, 190.0)[..., None], 3, 2)


def flat(_: int) -> np.ndarray:
    return np.full((SIDE, SIDE, 3), 128.0)


def snow(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0, 255, (SIDE, SIDE, 3))


OTHERS = (
    specks_on_a_gel := lambda seed: gel(seed=seed) * (1 - specks(seed)[..., None]),
    gel, grain_of_a_grey_frame, letters, stripes, weave, knurl, shell, one_row_of_holes,
    dots_in_one_corner, checkers, flat, snow,
)  # fmt: skip
NAMES = (
    "specks",
    "gel",
    "grain",
    "letters",
    "stripes",
    "weave",
    "knurl",
    "shell",
    "row",
    "corner",
    "checkers",
)


@pytest.mark.parametrize("make", OTHERS, ids=(*NAMES, "flat", "snow"))
@pytest.mark.parametrize("seed", range(3))
def test_a_picture_without_a_printed_grid_comes_back_as_it_is(make, seed: int) -> None:
    before = picture(make(seed=seed) if make is gel else make(seed))
    copy = before.copy()
    after, dots = fill_dots(before)
    assert dots is None and after is before and (after == copy).all()


def test_a_picture_too_small_for_a_grid_comes_back_as_it_is() -> None:
    small = picture(gel(40))
    assert fill_dots(small) == (small, None)


@pytest.mark.parametrize("name", ["TAG", "OF Real", "TQ-DuraGel"])
def test_a_simulated_press_loses_its_dots_and_the_press_drawn_without_dots_stays(name: str) -> None:
    domain = SIMULATED[name]
    made = thing(next(iter(planned(domain, "wood", pairs=8))), seed=0)
    sensor = replace(domain.sensor, plain_gels=0.0)
    bare = picture(255 * tactile(made, replace(sensor, markers=None), 5, size=SIDE))
    marked = picture(255 * tactile(made, sensor, 5, size=SIDE))
    assert fill_dots(bare)[0] is bare
    filled, dots = fill_dots(marked)
    change = np.abs(marked.astype(float) - bare).max(2)
    assert dots is not None
    assert (filled != marked).any(2)[change > 15].mean() > 0.95
    assert (
        np.abs(filled.astype(float) - bare)[change > 15].mean() < 0.25 * change[change > 15].mean()
    )
