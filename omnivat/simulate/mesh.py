"""The photographed object as a triangle mesh, and what is too fine for its vertices."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from omnivat.simulate.framing import Framing
from omnivat.simulate.noise import Array, turned
from omnivat.simulate.surfaces import Surface

_SIDE = 176  # vertices along each side of the object's top
_THICKNESS = 0.08  # of the view: how high the object stands on the ground


@dataclass(frozen=True, slots=True, kw_only=True)
class Mesh:
    """Vertices (N, 3) in mm with texture coordinates (N, 2), triangles (M, 3), and the ground's z."""

    vertices: Array
    texture: Array
    faces: NDArray[np.uint32]
    ground: float


def top_points(framing: Framing, *, side: int = _SIDE) -> tuple[Array, Array]:
    """Return the object's own coordinates (side, side) of points spread over its top, mm."""
    axis = np.linspace(-1.0, 1.0, side)
    s, t = np.meshgrid(axis, axis)
    power = 2.0 + 0.9 / framing.corner  # 2 is a disc; high powers are almost a rectangle
    square = np.maximum(np.abs(s), np.abs(t))
    rounded = (np.abs(s) ** power + np.abs(t) ** power) ** (1.0 / power)
    pull = 1.0 if framing.corner < 0.1 else square / np.maximum(rounded, 1e-9)
    along, across = s * pull * framing.size[0] / 2, t * pull * framing.size[1] / 2
    return turned(along, across, -framing.axis)


def object_mesh(surface: Surface, framing: Framing) -> Mesh:
    """Return the object: its displaced top, and a wall down to the ground all round."""
    u, v = top_points(framing)
    z = surface.form.height(u, v) + filtered_relief(surface, framing)
    ground = float(z.min()) - _THICKNESS * framing.view
    s, t = np.meshgrid(np.linspace(0, 1, _SIDE), np.linspace(0, 1, _SIDE))
    top = np.stack([u, v, z], axis=-1).reshape(-1, 3)
    rim = _rim()
    wall = top[rim] * [1.0, 1.0, 0.0] + [0.0, 0.0, ground]
    texture = np.stack([s, t], axis=-1).reshape(-1, 2)
    return Mesh(
        vertices=np.concatenate([top, top[rim], wall, wall, [[0.0, 0.0, ground]]]),
        texture=np.concatenate([texture, *[texture[rim]] * 3, [[0.5, 0.5]]]),
        faces=np.concatenate(
            [_top_faces(), _wall_faces(len(top), len(rim)), _floor_faces(len(top), len(rim))]
        ).astype(np.uint32),
        ground=ground - 0.002 * framing.view,
    )


def filtered_relief(surface: Surface, framing: Framing) -> Array:
    """Return the relief (side, side) at the vertices, averaged over the space between them."""
    u, v = top_points(framing, side=2 * _SIDE)
    fine = surface.relief(u + framing.at[0], v + framing.at[1])
    return np.asarray(fine.reshape(_SIDE, 2, _SIDE, 2).mean((1, 3)))


def colours(surface: Surface, framing: Framing) -> Array:
    """Return the object's colour as a texture (side, side, 3), averaged likewise."""
    u, v = top_points(framing, side=2 * _SIDE)
    fine = surface.colour(u + framing.at[0], v + framing.at[1])
    return np.asarray(fine.reshape(_SIDE, 2, _SIDE, 2, 3).mean((1, 3)))


def unresolved_slopes(surface: Surface, framing: Framing) -> tuple[float, float]:
    """Return root-mean-square slopes along and across the axis that the mesh is too coarse for.

    They widen the highlight, as they do in nature: a brushed sheet seen from afar is a rough mirror.
    """
    spacing = max(framing.size) / _SIDE
    axis = np.arange(-48, 48) * (spacing / 6)
    along, across = np.meshgrid(axis, axis)
    u, v = turned(along, across, -framing.axis)
    relief = surface.relief(u + framing.at[0], v + framing.at[1])
    fine = np.gradient(relief, spacing / 6)
    coarse = np.gradient(relief.reshape(16, 6, 16, 6).mean((1, 3)), spacing)
    lost = [max(float(f.var() - c.var()), 0.0) for f, c in zip(fine, coarse, strict=True)]
    return float(np.sqrt(lost[1])), float(np.sqrt(lost[0]))


def _top_faces() -> NDArray[np.int64]:
    index = np.arange(_SIDE * _SIDE).reshape(_SIDE, _SIDE)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]
    return np.concatenate(
        [np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)]
    )


def _rim() -> NDArray[np.int64]:
    """Return the indices of the top's border, once round."""
    index = np.arange(_SIDE * _SIDE).reshape(_SIDE, _SIDE)
    sides = (index[0, :-1], index[:-1, -1], index[-1, :0:-1], index[:0:-1, 0])
    return np.concatenate(sides)


def _wall_faces(first: int, count: int) -> NDArray[np.int64]:
    upper = first + np.arange(count)
    after = first + (np.arange(count) + 1) % count
    return np.concatenate(
        [
            np.stack([upper, upper + count, after], -1),
            np.stack([after, upper + count, after + count], -1),
        ]
    )


def _floor_faces(first: int, count: int) -> NDArray[np.int64]:
    """Return a fan over the object's underside; clear glass needs a way out."""
    start = first + 2 * count
    near, after = start + np.arange(count), start + (np.arange(count) + 1) % count
    return np.stack([near, np.full(count, start + count), after], -1)
