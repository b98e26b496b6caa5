"""Solids: their walls and edges by material, and ways to make, move and join them.

A solid is turned on a lathe, swept along a path, or cut as a rounded block.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from simulator.noise import Array, Rng, unit

_MADE = {  # least and most of wall and of bevel, mm
    "wood": ((6.0, 11.0), (2.0, 5.0)), "steel": ((0.7, 1.5), (0.3, 0.8)),
    "plastic": ((1.4, 3.0), (0.6, 1.5)), "ceramic": ((3.5, 6.5), (1.5, 3.0)),
    "glass": ((1.8, 3.8), (1.0, 2.0)),
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Made:
    """The thickness of an object's walls and the radius of its edges, mm."""

    wall: float
    bevel: float


def made_of(material: str, rng: Rng) -> Made:
    """Draw how an object of this material is made."""
    wall, bevel = (rng.uniform(*ends) for ends in _MADE[material])
    return Made(wall=wall, bevel=bevel)


Faces = NDArray[np.int64]
_SHEAR = 0.7  # how far the block's coordinates lean with height


@dataclass(frozen=True, slots=True, kw_only=True)
class Solid:
    """A closed mesh in mm; it stands on z = 0, z points up.

    vertices  (V, 3)
    faces     (F, 3), anticlockwise seen from outside
    uv        (V, 2), mm: where each vertex lies on the surface's own pattern
    """

    vertices: Array
    faces: Faces
    uv: Array

    def normals(self) -> Array:
        """Return unit normals (V, 3), outwards: the mean of the faces that meet, by area."""
        place = np.round(self.vertices * 1e3).astype(np.int64) + 10**6
        key = (place[:, 0] << 42) + (place[:, 1] << 21) + place[:, 2]
        _, same = np.unique(key, return_inverse=True)
        across = across_of(self.vertices[self.faces])
        meet = same[self.faces].ravel()
        total: Array = np.stack(
            [np.bincount(meet, weights=np.repeat(part, 3)) for part in across.T], axis=1
        )
        return unit(total[same])


def across_of(corner: Array) -> Array:
    """Return twice the area of each face (F, 3, 3) as a vector (F, 3) across it, outwards."""
    return np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])


def joined(*parts: Solid) -> Solid:
    """Return several solids as one; each keeps its coordinates on the pattern."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=False)])
    vertices, uv = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("vertices", "uv")
    )
    return Solid(vertices=vertices, faces=faces, uv=uv)


def placed(
    solid: Solid, *, at: Sequence[float] = (0.0, 0.0, 0.0), turn: float = 0.0, roll: float = 0.0
) -> Solid:
    """Return the solid rolled about x, turned about z (rad), then moved by `at` mm."""
    x, y, z = solid.vertices.T
    y, z = y * np.cos(roll) - z * np.sin(roll), y * np.sin(roll) + z * np.cos(roll)
    x, y = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
    return replace(solid, vertices=np.stack([x, y, z], axis=1) + np.asarray(at))


def grounded(solid: Solid) -> Solid:
    """Return the solid on z = 0, its middle over the origin."""
    low, high = solid.vertices.min(0), solid.vertices.max(0)
    return placed(solid, at=(-(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]))


def sawn(solid: Solid) -> Solid:
    """Return the solid with the pattern of a block that it is cut from, not wrapped round it."""
    x, y, z = solid.vertices.T
    return replace(solid, uv=np.stack([x + _SHEAR * z, y + _SHEAR * z], axis=1))


def assembled(*parts: Solid) -> Solid:
    """Return parts that are cut from one block and stand on z = 0."""
    return grounded(sawn(joined(*parts)))


def slab(made: Made, *size: float) -> Solid:
    """Return a block (length, width, height) mm on z = 0 with the edges of its material."""
    return grounded(block(size, bevel=made.bevel))


def grid(points: Array, uv: Array) -> Solid:
    """Return the mesh of points (rows, columns, 3); normals point along columns x rows."""
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (
        part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:])
    )
    faces = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    return Solid(vertices=points.reshape(-1, 3), faces=faces, uv=uv.reshape(-1, 2))


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
    for before, here, after, corner in zip(
        points, points[1:], points[2:], list(corners)[1:-1], strict=False
    ):
        back, ahead = before - here, after - here
        lengths = np.linalg.norm(back), np.linalg.norm(ahead)
        soft = min(corner[2], 0.49 * float(min(lengths)))
        start, end = here + back / lengths[0] * soft, here + ahead / lengths[1] * soft
        t = np.linspace(0.0, 1.0, _ARC)[:, None] if soft > 0.0 else np.zeros((1, 1))
        pieces.append((1 - t) ** 2 * start + 2 * t * (1 - t) * here + t**2 * end)
    # and more where two lie further apart than a step
    points = np.concatenate([*pieces, points[-1:]])
    away = np.linalg.norm(np.diff(points, axis=0), axis=1)
    counts = np.maximum(np.ceil(away / _STEP), 1).astype(int)
    pieces = [
        a + (b - a) * np.arange(n)[:, None] / n
        for a, b, n in zip(points, points[1:], counts, strict=False)
    ]
    return np.concatenate([*pieces, points[-1:]])


def turned(profile: Profile, *, power: float = 2.0, oblong: float = 1.0) -> Solid:
    """Return a solid of revolution; the profile runs from the axis below to the axis above.

    power   2 gives a round plan; 8 almost a square
    oblong  length of the plan by its width
    """
    line = outline(profile)
    radius, height = line[:, 0], line[:, 1]
    angle, cos, sin, plan = _around(AROUND, power)
    reach = np.maximum(radius, 1e-3)[:, None]
    points = _spread(reach * plan * cos * oblong, reach * plan * sin, height[:, None])
    return grid(points, _spread(angle * 0.8 * radius.max(), _along(line)[:, None]))


def _around(steps: int, power: float) -> tuple[Array, Array, Array, Array]:
    """Return angles once around, their cosine and sine, and the reach of |x|^p + |y|^p = 1."""
    angle = np.linspace(0.0, 2 * np.pi, steps + 1)
    cos, sin = np.cos(angle), np.sin(angle)
    return angle, cos, sin, (np.abs(cos) ** power + np.abs(sin) ** power) ** (-1.0 / power)


def lathed(profile: Profile, *, power: float = 2.0, oblong: float = 1.0) -> Solid:
    """Return `turned` of a profile that flat discs close below and above."""
    low, high = profile[0][1], profile[-1][1]
    return turned([(0.0, low, 0.0), *profile, (0.0, high, 0.0)], power=power, oblong=oblong)


def swept(path: Array, half: Array, *, power: float) -> Solid:
    """Return a closed bar along a path.

    path   (N, 3) mm
    half   (N, 2) half of the width (along y, or along x of a path that runs along y) and of the
           thickness at each point, mm
    power  2 gives an ellipse across; 4 a flat bar with rounded edges
    """
    way = unit(np.gradient(path, axis=0))
    aside = np.array([1.0, 0.0, 0.0] if abs(way[len(way) // 2, 1]) > 0.9 else [0.0, 1.0, 0.0])
    side = unit(aside - way * (way @ aside)[:, None])
    up = np.cross(way, side)
    angle, cos, sin, plan = _around(32, power)
    ends = np.ones((len(path), 1))  # each end falls to 0 like a quarter circle
    ends[[0, -1]], ends[[1, -2]] = 1e-3, 0.75
    wide, thick = half[:, :1] * ends, half[:, 1:] * ends
    across = wide[..., None] * (plan * cos)[None, :, None] * side[:, None]
    points = path[:, None] + across + thick[..., None] * (plan * sin)[None, :, None] * up[:, None]
    return grid(
        points, _spread(_along(path)[:, None], angle * np.maximum(half.mean(1), 0.5)[:, None])
    )


def _spread(*parts: Array) -> Array:
    """Return parts of a table as its last axis; a single row or column is repeated."""
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def _along(line: Array) -> Array:
    """Return how far each point (N,) of a line (N, D) lies from its start along the line."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


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
    way = _spread(
        np.cos(up)[:, None] * np.cos(round_),
        np.cos(up)[:, None] * np.sin(round_),
        np.sin(up)[:, None],
    )
    corner = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]])[np.arange(len(round_)) // 5]
    signs = _spread(*corner.T, np.where(np.arange(len(up)) < 5, -1, 1)[:, None])
    points = signs * (half - bevel) + bevel * way
    hull = grid(points, np.zeros((*points.shape[:2], 2)))
    return sawn(joined(hull, _lid(points[-1]), _lid(points[0][::-1])))


def _lid(rim: Array) -> Solid:
    """Return the flat face inside a closed rim (N, 3) that runs anticlockwise seen from outside."""
    vertices = np.concatenate([rim, rim.mean(0, keepdims=True)])
    index = np.arange(len(rim))
    faces = np.stack([index, np.roll(index, -1), np.full(len(rim), len(rim))], axis=1)
    return Solid(vertices=vertices, faces=faces, uv=np.zeros((len(vertices), 2)))
