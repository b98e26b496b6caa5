"""Fill the dots that are printed on a gel, and leave every other picture as it is.

A dot gets the membrane that its rim spans (Laplace's equation), and the grain of the gel half a
cell away: without grain, an encoder sees smooth discs. OpenCV's inpainting is slower and, to an
encoder, farther from the same press drawn without dots (docs/dots.md).

Programs that compute depth from GelSight pictures interpolate under the markers first:
github.com/siyuandong16/gelsight_heightmap_reconstruction and github.com/gelsightinc/gsrobotics.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from omnivat.data.grid import Grid, darkness, find_grid, reduction, running

Array = np.ndarray[Any, np.dtype[Any]]
SWEEPS = 2
SMALLEST = 64  # pixels: a smaller picture is not searched
FILLED = "; dots of TAC filled"  # in a set's preprocessing, before what follows


@dataclass(frozen=True, slots=True, kw_only=True)
class Dots:
    """The dots that were filled in one picture."""

    number: int
    pitch: tuple[float, float]  # pixels between dots along the grid's two steps
    size: float  # pixels: median diameter
    darkness: float  # median share of the gel's light that a dot takes, 0 to 1
    light: bool  # dots lighter than the gel; `darkness` is that of the negative
    share: float  # of the grid's nodes beside a dot that hold a dot, 0 to 1


def fill_dots(picture: Array) -> tuple[Array, Dots | None]:
    """Return the picture (H, W, 3) uint8 without its printed dots, and what was filled.

    Without a grid of dots, the same array comes back, and None.

    >>> y, x = np.mgrid[:224, :224]
    >>> printed = np.full((224, 224, 3), 150, np.uint8)
    >>> printed[np.hypot(x % 28 - 14, y % 28 - 14) < 4] = 30
    >>> clean, dots = fill_dots(printed)
    >>> dots.number, dots.pitch, bool((clean == 150).all())
    (64, (28.0, 28.0), True)
    """
    if min(picture.shape[:2]) < SMALLEST:
        return picture, None
    for light in (False, True):
        seen = 255 - picture if light else picture
        brightest = np.maximum(np.maximum(seen[..., 0], seen[..., 1]), seen[..., 2])
        grid = find_grid(brightest)
        if grid is not None:
            break
    else:
        return picture, None
    hole, number, size = dotted(brightest, grid)
    pitch = np.hypot(*grid.steps.T).round(1).tolist()
    dots = Dots(
        number=number,
        pitch=(pitch[0], pitch[1]),
        size=round(size, 1),
        darkness=round(grid.darkness, 3),
        light=light,
        share=round(grid.share, 3),
    )
    return filled(picture, hole, grid.steps), dots


def dots_of(preprocessing: str) -> str:
    """Return "fill" or "keep", as which a set's preprocessing took the dots of TAC."""
    return "fill" if FILLED in preprocessing else "keep"


def dotted(brightest: Array, grid: Grid) -> tuple[Array, int, float]:
    """Return which pixels (H, W) are dots of the grid, the number of dots, and their median
    diameter.
    """
    from scipy.ndimage import label

    height, width = brightest.shape
    reach = int(0.45 * np.hypot(*grid.steps.T).min())
    near = np.arange(-reach, reach + 1)
    disk = near**2 + near[:, None] ** 2 <= reach**2
    middle = max(1, reach // 4)
    core = (slice(None), *[slice(reach - middle, reach + middle + 1)] * 2)
    dark = grid.dark if grid.dark.shape == brightest.shape else darkness(brightest)
    padded = np.pad(dark, reach)
    columns, rows = grid.nodes.T
    windows = np.lib.stride_tricks.sliding_window_view(padded, disk.shape)[rows, columns]
    depth = windows[core].max((1, 2))
    least = np.ceil(np.maximum(0.35 * depth, 64 * grid.darkness)).astype(np.uint8)
    inky = (windows >= least[:, None, None]) & disk
    canvas = np.zeros(padded.shape, bool)
    for x, y, ink in zip(columns, rows, inky, strict=True):
        canvas[y : y + len(disk), x : x + len(disk)] |= ink
    canvas = canvas[reach : reach + height, reach : reach + width]
    # Of what is dark near a node, only what touches its middle belongs to the dot.
    names, _ = label(canvas)
    middles = np.lib.stride_tricks.sliding_window_view(np.pad(names, reach), disk.shape)[
        rows, columns
    ]
    dots = np.unique(middles[core])
    dots = dots[dots > 0]
    areas = np.bincount(names.ravel())
    chosen = np.zeros(len(areas), bool)
    chosen[dots] = True
    hole = running(chosen[names], 2 * reduction(names.shape) + 1, np.logical_or)
    return hole, len(dots), float(2 * np.sqrt(np.median(areas[dots]) / np.pi))


def filled(picture: Array, hole: Array, steps: Array) -> Array:
    """Return the picture (H, W, 3) uint8 with its holes (H, W) filled from their rims, and grain
    from half a cell of the grid (steps (2, 2), pixels) away.
    """
    height, width = hole.shape
    here = np.flatnonzero(hole)
    rows, columns = np.divmod(here, width)
    value = membrane(picture, hole).reshape(height * width, -1).take(here, 0)
    fine = grain(picture).reshape(height * width, -1)
    plain = ~running(hole, 3, np.logical_or).ravel()
    empty = np.arange(len(here))
    for right, down in ((steps[0] + steps[1]) / 2, (steps[0] - steps[1]) / 2):
        for sign in (1, -1):
            y, x = (
                rows[empty] + sign * round(float(down)),
                columns[empty] + sign * round(float(right)),
            )
            place = y * width + x
            inside = (y > 0) & (x > 0) & (y < height - 1) & (x < width - 1)
            usable = inside & plain.take(np.where(inside, place, 0))
            value[empty[usable]] += fine.take(place[usable], 0)
            empty = empty[~usable]
    result = picture.copy()
    result.reshape(height * width, -1)[here] = np.clip(np.rint(value), 0, 255)
    return result


def grain(picture: Array) -> Array:
    """Return the picture (H, W, 3) less the mean of the 3 × 3 pixels around each, float32; 0 at
    the rim.
    """
    rows = picture[:-2].astype(np.uint16) + picture[1:-1] + picture[2:]
    around = rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]
    fine = picture[1:-1, 1:-1] - around / np.float32(9)
    return np.pad(fine, ((1, 1), (1, 1), (0, 0)))


def membrane(picture: Array, hole: Array) -> Array:
    """Return the picture (H, W, C) float32 with Laplace's equation solved in its holes (H, W):
    first in the picture of half the size, then by SWEEPS of relaxation.
    """
    height, width = hole.shape
    here = np.flatnonzero(hole)
    known, values = (~hole)[..., None].astype(picture.dtype), picture.copy()
    values.reshape(height * width, -1)[here] = 0
    rim = ((0, height % 2), (0, width % 2), (0, 0))
    weight, total = halved(np.pad(known, rim)), halved(np.pad(values, rim))
    empty = weight[..., 0] == 0
    half = total / np.maximum(weight, 1)
    if empty.any() and not empty.all():
        half = membrane(half, empty)
    rows, columns = np.divmod(here, width)
    flat = picture.astype(np.float32).reshape(height * width, -1)
    flat[here] = half.reshape(-1, half.shape[2]).take(rows // 2 * half.shape[1] + columns // 2, 0)
    up, down = here - width * (rows > 0), here + width * (rows < height - 1)
    left, right = here - (columns > 0), here + (columns < width - 1)
    for _ in range(SWEEPS):
        around = flat.take(up, 0) + flat.take(down, 0) + flat.take(left, 0) + flat.take(right, 0)
        flat[here] = around * np.float32(0.25)
    return flat.reshape(picture.shape)


def halved(values: Array) -> Array:
    """Return the sums of blocks of 2 × 2, float32."""
    rows = values[::2].astype(np.float32) + values[1::2]
    return np.asarray(rows[:, ::2] + rows[:, 1::2])
