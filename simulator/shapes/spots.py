"""The touched spot of an object, with room for a sensor, and the object's height map around it."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter, zoom

from simulator.noise import Array, Rng, unit
from simulator.shapes.solid import Faces, Solid, across_of

_DRAWN = 16
_EDGES = 0.35  # of the presses are on an edge, a rim or a curve
_ROOM = 60.0  # mm above the place that a sensor needs


@dataclass(frozen=True, slots=True, kw_only=True)
class Spot:
    """A touched place: unit vectors (3,) and a point (3,) in mm on the solid; `uv` in mm."""

    point: Array
    normal: Array
    tangent: Array  # along which the pattern's first coordinate grows
    uv: Array


def spot(solid: Solid, rng: Rng, *, edges: bool) -> Spot:
    """Draw a touched place: not underneath, with room for a sensor, often a rim or an edge if
    `edges`.
    """
    corner, normal = solid.vertices[solid.faces], solid.normals()[solid.faces]
    bent = rng.random() < _EDGES and edges
    weight = _bends(normal, corner) if bent else np.linalg.norm(across_of(corner), axis=1)
    face = rng.choice(len(weight), size=_DRAWN, p=weight / weight.sum())
    share = rng.dirichlet((1.0, 1.0, 1.0), _DRAWN)
    points = np.einsum("nk,nkd->nd", share, corner[face])
    normals = unit(np.einsum("nk,nkd->nd", share, normal[face]))
    best = _first_free(solid, points, normals)
    there = solid.faces[face[best]]
    tangent = _along(solid.vertices[there], solid.uv[there], normals[best])
    return Spot(
        point=points[best], normal=normals[best], tangent=tangent, uv=share[best] @ solid.uv[there]
    )


def _bends(normal: Array, corner: Array) -> Array:
    """Return, for each face, its longest side times how far the surface turns over it."""
    turn = np.linalg.norm(normal - np.roll(normal, 1, axis=1), axis=-1).max(axis=1)
    side = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=-1).max(axis=1)
    return turn * side + 1e-9


def _first_free(solid: Solid, points: Array, normals: Array) -> int:
    """Return the first spot that is not underneath and has room above it, or the best one."""
    above = (normals[:, 2] > -0.3) & ((points[:, 2] > 3.0) | (normals[:, 2] > 0.5))
    order = np.argsort(~above, kind="stable")
    for index in order:
        start = points[index] + 0.05 * normals[index]
        if not blocked(solid, start, start + _ROOM * normals[index]):
            return int(index)
    return int(order[0])


def blocked(solid: Solid, start: Array, end: Array) -> bool:
    """True if the solid lies between two points, (3,) mm."""
    corner = solid.vertices[solid.faces]
    ray, one, two = end - start, corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    cross = np.cross(ray, two)
    det = np.einsum("fd,fd->f", one, cross)
    det = np.where(np.abs(det) < 1e-12, np.inf, det)
    away = start - corner[:, 0]
    u = np.einsum("fd,fd->f", away, cross) / det
    back = np.cross(away, one)
    v = (back @ ray) / det
    t = np.einsum("fd,fd->f", two, back) / det
    return bool(((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-4) & (t < 1 - 1e-4)).any())


def _along(corner: Array, uv: Array, normal: Array) -> Array:
    """Return the unit direction in the face along which u grows; any if undefined."""
    edges, steps = corner[1:] - corner[0], uv[1:] - uv[0]
    if abs(np.linalg.det(steps)) > 1e-6:
        way = np.linalg.solve(steps, edges)[0]
    else:
        way = np.cross(normal, [0.0, 0.0, 1.0]) + np.array([1e-6, 0.0, 0.0])
    way = way - normal * (way @ normal)
    return way / np.linalg.norm(way)


BELOW = -6.0  # mm: deeper parts are out of reach of every sensor
_ABOVE = 6.0  # mm: higher parts above the touched spot are ignored
_FINEST = 144  # pixels of a side that are drawn; larger maps are resampled
_BULGE = 0.6  # mm: largest bulge of a curved face over its flat triangle
_CREASE = 0.7  # cosine of the angle between faces that form an edge


def contact_height(
    solid: Solid, spot: Spot, *, field: float, size: int, turn: float = 0.0
) -> Array:
    """Return the height (size, size) in mm of the solid around the touched spot, along its normal.

    field  mm across the square map; x grows to the right and y upwards
    turn   rad about the normal, from the spot's tangent to the map's x

    Curved parts are smooth: heights follow the normals of the vertices, not the flat triangles.
    The touched spot has height 0; nothing is deeper than `BELOW`.
    """
    side = min(size, _FINEST)
    corner, normal = _nearby(solid, _axes(spot, turn), spot.point, field)
    drawn = np.maximum(_drawn(corner, normal, field=field, side=side), BELOW)
    if side == size:
        return drawn
    wide = zoom(drawn, size / side, order=1, mode="nearest", grid_mode=True)
    return gaussian_filter(wide, 0.6 * size / side, mode="nearest")


def _axes(spot: Spot, turn: float) -> Array:
    """Return the map's x, y and height as rows (3, 3) of unit vectors in the solid's space."""
    up = spot.normal / np.linalg.norm(spot.normal)
    along = spot.tangent - up * (spot.tangent @ up)
    along = along / np.linalg.norm(along)
    across = np.cross(up, along)
    cos, sin = np.cos(turn), np.sin(turn)
    return np.stack([cos * along + sin * across, cos * across - sin * along, up])


def _nearby(solid: Solid, axes: Array, point: Array, field: float) -> tuple[Array, Array]:
    """Return corners and corner normals (F, 3, 3), in the map's axes, of the faces in reach."""
    local = (solid.vertices - point) @ axes.T
    corner = local[solid.faces]
    low, high = corner.min(1), corner.max(1)
    half = field / 2
    seen = (low[:, :2] < half).all(1) & (high[:, :2] > -half).all(1)
    seen &= (high[:, 2] > BELOW) & (low[:, 2] < _ABOVE)
    corner = corner[seen]
    flat = unit(across_of(corner))
    smooth = (solid.normals() @ axes.T)[solid.faces[seen]]
    curved = (smooth * flat[:, None]).sum(-1, keepdims=True) > _CREASE
    normal = np.where(curved, smooth, flat[:, None])
    up = flat[:, 2] > 1e-3
    return corner[up], normal[up]


def _drawn(corner: Array, normal: Array, *, field: float, side: int) -> Array:
    """Return the highest face at each pixel (side, side), -inf where there is none."""
    face, row, column = _covered(corner, field=field, side=side)
    x = (column + 0.5) / side * field - field / 2
    y = field / 2 - (row + 0.5) / side * field
    share = _shares(corner, face, x, y)
    inside = (share > -1e-9).all(0)
    height = _curved(corner, normal, face[inside], share[:, inside], x[inside], y[inside])
    height = np.where(height < _ABOVE, height, -np.inf)
    image = np.full(side * side, -np.inf)
    np.maximum.at(image, (row * side + column)[inside], height)
    return image.reshape(side, side)


def _covered(corner: Array, *, field: float, side: int) -> tuple[Faces, Faces, Faces]:
    """Return (face, row, column) of every pixel in each face's bounding box."""
    scale, middle = side / field, side / 2
    places = corner[:, :, :2] * [scale, -scale] + middle - 0.5
    low = np.clip(np.ceil(places.min(1)), 0, side).astype(np.int64)
    high = np.clip(np.floor(places.max(1)) + 1, 0, side).astype(np.int64)
    wide, tall = np.maximum(high - low, 0).T
    count = wide * tall
    face = np.repeat(np.arange(len(corner)), count)
    order = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    return face, low[face, 1] + order // wide[face], low[face, 0] + order % wide[face]


def _shares(corner: Array, face: Faces, x: Array, y: Array) -> Array:
    """Return barycentric coordinates (3, N) of points in their faces, seen from above."""
    a, b, c = (corner[:, index, :2] for index in range(3))
    one, two = b - a, c - a
    area = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    area = np.where(np.abs(area) < 1e-12, np.inf, area)[face]
    dx, dy = x - a[face, 0], y - a[face, 1]
    second = (dx * two[face, 1] - dy * two[face, 0]) / area
    third = (dy * one[face, 0] - dx * one[face, 1]) / area
    return np.stack([1.0 - second - third, second, third])


def _curved(corner: Array, normal: Array, face: Faces, share: Array, x: Array, y: Array) -> Array:
    """Return heights (N,): the mean of the flat face and the blended planes of its corners.

    This is exact for a parabolic surface.
    """
    slope = -normal[..., :2] / np.maximum(normal[..., 2:], 0.25)
    flat, lift = np.zeros(len(face)), np.zeros(len(face))
    for index in range(3):
        here, tilt = corner[:, index][face], slope[:, index][face]
        plane = tilt[:, 0] * (x - here[:, 0]) + tilt[:, 1] * (y - here[:, 1])
        flat += share[index] * here[:, 2]
        lift += share[index] * (plane + here[:, 2])
    return flat + np.clip(0.5 * (lift - flat), -_BULGE, _BULGE)
