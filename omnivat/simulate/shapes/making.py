"""Three ways to make a solid: turned on a lathe, swept along a path, cut as a rounded block."""

from collections.abc import Sequence

import numpy as np

from omnivat.simulate.noise import Array
from omnivat.simulate.shapes.solid import Solid, grid, joined, sawn

AROUND = 84  # columns of a turned solid
_STEP = 5.0  # mm: longest stretch of a profile between two rows
_ARC = 6  # points of a rounded corner

Point = tuple[float, float]
Profile = Sequence[tuple[float, float, float]]  # radius, height, softness of the corner; mm


def outline(corners: Profile) -> Array:
    """Return the points (N, 2) of an open line whose inner corners are rounded, in mm.

    corners  (x, y, softness): how far before and after the corner the rounding begins, cut to
             just under half of the shorter neighbour
    """
    points = np.array([corner[:2] for corner in corners], dtype=np.float64)
    pieces = [points[:1]]
    for before, here, after, corner in zip(points, points[1:], points[2:], list(corners)[1:-1], strict=False):
        back, ahead = before - here, after - here
        lengths = np.linalg.norm(back), np.linalg.norm(ahead)
        soft = min(corner[2], 0.49 * float(min(lengths)))
        start, end = here + back / lengths[0] * soft, here + ahead / lengths[1] * soft
        t = np.linspace(0.0, 1.0, _ARC)[:, None] if soft > 0.0 else np.zeros((1, 1))
        pieces.append((1 - t) ** 2 * start + 2 * t * (1 - t) * here + t**2 * end)
    return _dense(np.concatenate([*pieces, points[-1:]]))


def _dense(points: Array) -> Array:
    """Return the line with points added where two lie further apart than a step."""
    away = np.linalg.norm(np.diff(points, axis=0), axis=1)
    counts = np.maximum(np.ceil(away / _STEP), 1).astype(int)
    pieces = [a + (b - a) * np.arange(n)[:, None] / n for a, b, n in zip(points, points[1:], counts, strict=False)]
    return np.concatenate([*pieces, points[-1:]])


def turned(profile: Profile, *, power: float = 2.0, oblong: float = 1.0) -> Solid:
    """Return a solid of revolution; the profile runs from the axis below to the axis above.

    power   2 gives a round plan; 8 almost a square
    oblong  length of the plan by its width
    """
    line = outline(profile)
    radius, height = line[:, 0], line[:, 1]
    angle = np.linspace(0.0, 2 * np.pi, AROUND + 1)
    cos, sin = np.cos(angle), np.sin(angle)
    plan = (np.abs(cos) ** power + np.abs(sin) ** power) ** (-1.0 / power)
    reach = np.maximum(radius, 1e-3)[:, None]
    points = np.stack(
        [reach * plan * cos * oblong, reach * plan * sin, np.repeat(height[:, None], len(angle), 1)], axis=-1
    )
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    u = np.repeat((angle * 0.8 * radius.max())[None], len(line), 0)
    v = np.repeat(along[:, None], len(angle), 1)
    return grid(points, np.stack([u, v], axis=-1))


def swept(path: Array, half: Array, *, power: float = 2.0) -> Solid:
    """Return a closed bar along a path.

    path   (N, 3) mm
    half   (N, 2) half of the width (along y, or along x of a path that runs along y) and of the
           thickness at each point, mm
    power  2 gives an ellipse across; 4 a flat bar with rounded edges
    """
    way = np.gradient(path, axis=0)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    aside = np.array([1.0, 0.0, 0.0] if abs(way[len(way) // 2, 1]) > 0.9 else [0.0, 1.0, 0.0])
    side = aside - way * (way @ aside)[:, None]
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(way, side)
    angle = np.linspace(0.0, 2 * np.pi, 33)
    cos, sin = np.cos(angle), np.sin(angle)
    plan = (np.abs(cos) ** power + np.abs(sin) ** power) ** (-1.0 / power)
    ends = _ends(len(path))
    wide, thick = half[:, :1] * ends, half[:, 1:] * ends
    across = wide[..., None] * (plan * cos)[None, :, None] * side[:, None]
    points = path[:, None] + across + thick[..., None] * (plan * sin)[None, :, None] * up[:, None]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    v = angle[None] * np.maximum(half.mean(1), 0.5)[:, None]
    return grid(points, np.stack([np.repeat(along[:, None], 33, 1), v], axis=-1))


def _ends(count: int) -> Array:
    """Return 1 along a bar and a quarter circle's fall to 0 at both of its ends, (N, 1)."""
    ends = np.ones((count, 1))
    ends[[0, -1]] = 1e-3
    ends[[1, -2]] = 0.75
    return ends


def bar(start: Sequence[float], end: Sequence[float], half: Point, *, power: float = 4.0) -> Solid:
    """Return a straight bar with rounded ends; `half` is half of its width and thickness, mm."""
    a, b = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    length = float(np.linalg.norm(b - a))
    step = min(0.3 * min(half), 0.2 * length) / length
    t = np.concatenate([[0.0, step], np.linspace(2.5 * step, 1 - 2.5 * step, 12), [1 - step, 1.0]])
    path = a + t[:, None] * (b - a)
    return swept(path, np.repeat([half], len(t), 0), power=power)


def block(size: Sequence[float], *, bevel: float) -> Solid:
    """Return a box of `size` (length, width, height) mm whose edges are rounded by `bevel` mm."""
    half = np.asarray(size, dtype=np.float64) / 2
    bevel = min(bevel, 0.45 * 2 * float(half.min()))
    quarter = np.linspace(0.0, np.pi / 2, 5)
    up = np.concatenate([quarter - np.pi / 2, quarter])  # the middle twice: the flat sides
    round_ = np.concatenate([quarter + k * np.pi / 2 for k in range(4)] + [[2 * np.pi]])
    way = np.stack(
        [
            np.cos(up)[:, None] * np.cos(round_)[None], np.cos(up)[:, None] * np.sin(round_)[None],
            np.repeat(np.sin(up)[:, None], len(round_), 1),
        ],
        axis=-1,
    )  # fmt: skip
    which = np.minimum(np.arange(len(round_)) // 5, 4) % 4
    corner = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])[which]
    signs = np.concatenate(
        [
            np.repeat(corner[None], len(up), 0),
            np.repeat(np.where(np.arange(len(up)) < 5, -1, 1)[:, None, None], len(round_), 1),
        ],
        axis=-1,
    )
    points = signs * (half - bevel) + bevel * way
    hull = grid(points, np.zeros((*points.shape[:2], 2)))
    return sawn(joined(hull, _lid(points[-1]), _lid(points[0][::-1])))


def _lid(rim: Array) -> Solid:
    """Return the flat face inside a closed rim (N, 3) that runs anticlockwise seen from outside."""
    vertices = np.concatenate([rim, rim.mean(0, keepdims=True)])
    index = np.arange(len(rim))
    faces = np.stack([index, np.roll(index, -1), np.full(len(rim), len(rim))], axis=1)
    return Solid(vertices=vertices, faces=faces, uv=np.zeros((len(vertices), 2)))
