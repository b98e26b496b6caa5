"""Find the grid of dots that is printed on a gel.

A printed dot darkens all three colours and repeats in a square grid. Relief is coloured on one
side, or has no period. So: find dark spots in the brightest channel; let all pairs of spots vote
for the two steps of the grid; keep the spots that have neighbours one step away; accept the grid
only if few nodes are missing, few other spots are as dark, and the gel between them is plain.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[Any]]

SIDE = 224  # pixels, about: shorter side of the reduced picture that is searched
WIDEST = 0.085  # of the shorter side: diameter of the widest dot
LONGEST = 0.28  # of the shorter side: longest step
SHORTEST = 11  # pixels of the reduced picture: shortest step
MOST = 256  # spots
FAINTEST = 26  # of 255: darkness of the faintest spot
NODES = 16  # fewest of a grid
FAINT = (0.35, 0.7)  # of a dark spot: what counts beside it; the second if relief repeats, too
SUPPORT = 0.22  # of the pairs that a full grid has: fewest that share its best step
STRAY = 0.24  # steps between a node and its place


@dataclass(frozen=True, slots=True, kw_only=True)
class Grid:
    """A grid of dots in a picture."""

    dark: Array  # (H, W) 0 to 255: darkness of the reduced picture that was searched
    nodes: Array  # (n, 2) int: x and y in pixels
    steps: Array  # (2, 2): x and y of the two steps in pixels
    darkness: float  # median share of the light that a dot takes, 0 to 1
    share: float  # of the places beside a node, inside the picture, that hold a node


def find_grid(brightest: Array) -> Grid | None:
    """Return the grid of dark dots in a picture's brightest channel, (H, W) uint8, or None."""
    scale = reduction(brightest.shape)
    dark = darkness(reduced(brightest, scale))
    points, depths = spots(dark)
    if len(points) < NODES:
        return None
    for share in FAINT:
        kept = depths >= share * depths[NODES - 1]
        grid = grid_of(dark, points[kept], depths[kept])
        if grid is not None:
            nodes = grid.nodes * scale + scale // 2
            return replace(grid, nodes=nodes, steps=grid.steps * scale)
    return None


def grid_of(dark: Array, points: Array, depths: Array) -> Grid | None:
    """Return the grid that spots form, or None.

    dark    (H, W) 0 to 255: how dark each pixel is
    points  (n, 2): x and y of the spots; depths (n,): their darkness
    """
    shape = dark.shape
    steps = common_steps(points, shape)
    if steps is None:
        return None
    links, places = neighbours(points, steps, shape)
    linked = links >= 0
    along = (linked | ~places).reshape(2, 2, -1).any(1)  # or no neighbour fits into the picture
    node = largest(links, np.asarray(along.all(0) & linked.any(0)))
    if node.sum() < NODES:
        return None
    typical = np.median(depths[node])
    share = ((linked | ~places) & node).sum() / (4 * node.sum())
    others = (depths >= 0.6 * typical) & ~node
    reach = np.ptp(points[node], axis=0) / shape[::-1]
    if (
        share < 0.8
        or others.sum() > node.sum()
        or reach.min() < 0.65
        or between(dark, points[node], steps) > 0.42 * typical
    ):
        return None
    exact = [
        np.median(points[links[k][hit]] - points[hit], axis=0)
        for k, hit in ((k, linked[k] & node) for k in (0, 2))
    ]
    # A dot at the rim or beside strong relief may lack neighbours; one of them is a node.
    beside = (linked & node[links]).any(0) & (depths >= 0.4 * typical)
    return Grid(
        dark=dark,
        nodes=points[node | beside],
        steps=np.stack(exact),
        darkness=float(typical) / 255,
        share=float(share),
    )


def reduction(shape: tuple[int, ...]) -> int:
    """Return by which whole number a picture (H, W) is reduced before the search."""
    return max(1, round(min(shape) / SIDE))


def reduced(values: Array, scale: int) -> Array:
    """Return the means of blocks of `scale` pixels, without what is left over at the end."""
    if scale == 1:
        return values
    height, width = (side // scale for side in values.shape)
    exact = np.uint16 if scale <= 16 else np.uint32  # holds 255 scale²
    whole = values[: height * scale, : width * scale].astype(exact)
    rows = sum((whole[shift::scale] for shift in range(1, scale)), start=whole[::scale])
    total = sum((rows[:, shift::scale] for shift in range(1, scale)), start=rows[:, ::scale])
    return np.asarray(total // scale**2, np.uint8)


def running(values: Array, size: int, extreme: Callable[[Array, Array], Array]) -> Array:
    """Return the extreme of the square of `size` (odd) pixels around each pixel; edges repeat."""
    padded, width = np.pad(values, size // 2, mode="edge"), 1
    while width < size:
        step = min(width, size - width)
        padded = extreme(padded[:-step], padded[step:])
        padded = extreme(padded[:, :-step], padded[:, step:])
        width += step
    return np.asarray(padded)


def summed(values: Array, size: int) -> Array:
    """Return the sum of the square of `size` (odd) pixels around each pixel, in the type of
    `values`; edges repeat.
    """
    padded = np.pad(values, size // 2, mode="edge")
    height, width = values.shape
    rows: Any = sum(padded[shift : shift + height] for shift in range(size))
    return np.asarray(sum(rows[:, shift : shift + width] for shift in range(size)))


def darkness(brightest: Array) -> Array:
    """Return what share of the surroundings' light (0 to 255) each narrow dark thing takes, (H,
    W).
    """
    widest = int(WIDEST * min(brightest.shape) / 2) * 2 + 1
    closed = running(running(brightest, widest, np.maximum), widest, np.minimum)
    return ((closed - brightest) * np.float32(255) / np.maximum(closed, 24)).astype(np.uint8)


def spots(dark: Array) -> tuple[Array, Array]:
    """Return the places (n, 2) of the darkest spots, as x and y, and their darkness (n,),
    darkest first.
    """
    from scipy.ndimage import label

    total = summed(dark.astype(np.uint16), 5)  # at most 25 × 255
    rank = summed(total, 3)  # a wide dot is flat: smoothed again, it has a middle
    names, number = label((rank == running(rank, 7, np.maximum)) & (total >= FAINTEST * 25))
    rows, columns = np.nonzero(names)
    name = names[rows, columns]
    size = np.maximum(np.bincount(name, minlength=number + 1), 1)
    places = np.stack([np.bincount(name, side, number + 1) // size for side in (columns, rows)], 1)
    places = places[1:].astype(np.int64)
    depths = total[places[:, 1], places[:, 0]].astype(np.int64) // 25
    keep = np.argsort(-depths, kind="stable")[:MOST]
    return places[keep], depths[keep]


def common_steps(points: Array, shape: tuple[int, ...]) -> Array | None:
    """Return the two steps (2, 2), as x and y, that most pairs of points share, or None.

    A printed grid is nearly square and nearly upright.
    """
    height, width = shape
    reach = int(LONGEST * min(shape))
    code = points[:, 1] * 2 * width + points[:, 0]
    pairs = (code[None] - code[:, None]).ravel() + height * 2 * width + width
    votes = np.bincount(pairs, minlength=4 * height * width).reshape(-1, 2 * width)
    ends = (slice(side - reach - 3, side + reach + 4) for side in shape)
    votes = summed(summed(votes[*ends].astype(np.int32), 5), 3)[3:-3, 3:-3]
    near = np.arange(-reach, reach + 1)
    # Of a full grid, this many points have a partner inside the picture.
    possible = np.outer(1 - np.abs(near) / height, 1 - np.abs(near) / width) * len(points)
    score = votes / (9 * possible)
    score[near[:, None] ** 2 + near**2 < SHORTEST**2] = 0
    best = score.max()
    if best < SUPPORT:
        return None
    down, right = np.nonzero((score >= 0.5 * best) & (score == running(score, 9, np.maximum)))
    order = np.argsort(near[right] ** 2 + near[down] ** 2, kind="stable")
    steps, support = np.stack([near[right], near[down]], 1)[order], score[down, right][order]
    first = steps[(support >= 0.7 * best).argmax()]
    for second in steps:
        lengths = np.hypot(*first) * np.hypot(*second)
        if abs(first[0] * second[1] - first[1] * second[0]) > 0.75 * lengths:
            leaning = np.abs([first, second]).min(1) > 0.36 * np.abs([first, second]).max(1)
            square = 0.6 * (first @ first) <= lengths <= 1.8 * (first @ first)
            return np.stack([first, second]) if square and not leaning.all() else None
    return None


def neighbours(points: Array, steps: Array, shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Return each point's neighbour one step forth and back, for both steps, (4, n), -1 if it has
    none, and whether its place is inside the picture, (4, n). A neighbour's neighbour back is the
    point.
    """
    index = np.arange(len(points))
    limit = STRAY**2 * (steps[0] @ steps[0])
    x, y = points.T.astype(np.int32)
    across, down = x[None] - x[:, None], y[None] - y[:, None]
    links, places = [], []
    for step in steps:
        away = (across - step[0]) ** 2 + (down - step[1]) ** 2
        forth, back = away.argmin(1), away.argmin(0)
        forth = np.where((back[forth] == index) & (away[index, forth] <= limit), forth, -1)
        behind = np.full(len(points), -1)
        behind[forth[forth >= 0]] = index[forth >= 0]
        links += [forth, behind]
        for place in (points + step, points - step):
            places.append(((place > 3) & (place < np.subtract(shape[::-1], 4))).all(1))
    return np.stack(links), np.stack(places)


def largest(links: Array, good: Array) -> Array:
    """Return which points (n,) belong to the largest group of good points that are linked."""
    names = np.where(good, np.arange(len(good)), -1)
    while True:
        widened = np.where(
            good, np.maximum(names, np.where(links >= 0, names[links], -1).max(0)), -1
        )
        if (widened == names).all():
            break
        names = widened
    return np.asarray(good & (names == np.bincount(names[good], minlength=1).argmax()))


def between(dark: Array, nodes: Array, steps: Array) -> float:
    """Return the median darkness halfway between nodes."""
    halves = np.vstack([steps, steps.sum(0)]) // 2
    columns, rows = np.concatenate([nodes + half for half in halves]).T
    inside = (columns > 0) & (rows > 0) & (columns < dark.shape[1] - 1) & (rows < dark.shape[0] - 1)
    columns, rows = columns[inside], rows[inside]
    return float(np.median(summed(dark.astype(np.uint16), 3)[rows, columns] // 9))
