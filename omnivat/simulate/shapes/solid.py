"""Solids: their walls and edges by material, and ways to make, move and join them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from omnivat.simulate.noise import Array

_WALL = {  # mm
    "wood": (6.0, 11.0), "steel": (0.7, 1.5), "plastic": (1.4, 3.0), "ceramic": (3.5, 6.5),
    "glass": (1.8, 3.8),
}  # fmt: skip
_BEVEL = {  # mm
    "wood": (2.0, 5.0), "steel": (0.3, 0.8), "plastic": (0.6, 1.5), "ceramic": (1.5, 3.0),
    "glass": (1.0, 2.0),
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Made:
    """The thickness of an object's walls and the radius of its edges, mm."""

    wall: float
    bevel: float


def made_of(material: str, rng: np.random.Generator) -> Made:
    """Draw how an object of this material is made."""
    return Made(wall=float(rng.uniform(*_WALL[material])), bevel=float(rng.uniform(*_BEVEL[material])))


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
        corner = self.vertices[self.faces]
        across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        meet = same[self.faces].ravel()
        total = np.stack([np.bincount(meet, weights=np.repeat(part, 3)) for part in across.T], axis=1)
        normal = total[same]
        return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None])


def joined(*parts: Solid) -> Solid:
    """Return several solids as one; each keeps its coordinates on the pattern."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    return Solid(
        vertices=np.concatenate([part.vertices for part in parts]),
        faces=np.concatenate([p.faces + s for p, s in zip(parts, starts, strict=False)]),
        uv=np.concatenate([part.uv for part in parts]),
    )


def placed(solid: Solid, *, at: Sequence[float] = (0.0, 0.0, 0.0), turn: float = 0.0, roll: float = 0.0) -> Solid:
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


def grid(points: Array, uv: Array) -> Solid:
    """Return the mesh of points (rows, columns, 3); normals point along columns x rows."""
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    faces = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    return Solid(vertices=points.reshape(-1, 3), faces=faces, uv=uv.reshape(-1, 2))
