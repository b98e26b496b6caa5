"""The touched spot of an object, with room for a sensor."""

from dataclasses import dataclass

import numpy as np

from omnivat.simulate.noise import Array
from omnivat.simulate.shapes.solid import Solid

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


def spot(solid: Solid, rng: np.random.Generator, *, edges: bool = True) -> Spot:
    """Draw a touched place: not underneath, with room for a sensor, often a rim or an edge if `edges`."""
    corner, normal = solid.vertices[solid.faces], solid.normals()[solid.faces]
    bent = rng.random() < _EDGES and edges
    weight = _bends(normal, corner) if bent else _areas(corner)
    face = rng.choice(len(weight), size=_DRAWN, p=weight / weight.sum())
    share = rng.dirichlet((1.0, 1.0, 1.0), _DRAWN)
    points = np.einsum("nk,nkd->nd", share, corner[face])
    normals = _unit(np.einsum("nk,nkd->nd", share, normal[face]))
    best = _first_free(solid, points, normals)
    there = solid.faces[face[best]]
    return Spot(
        point=points[best],
        normal=normals[best],
        tangent=_along(solid.vertices[there], solid.uv[there], normals[best]),
        uv=share[best] @ solid.uv[there],
    )


def _areas(corner: Array) -> Array:
    across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return np.asarray(np.linalg.norm(across, axis=1))


def _bends(normal: Array, corner: Array) -> Array:
    """Return, for each face, its longest side times how far the surface turns over it."""
    turn = np.linalg.norm(normal - np.roll(normal, 1, axis=1), axis=-1).max(axis=1)
    side = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=-1).max(axis=1)
    return np.asarray(turn * side + 1e-9)


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
    return np.asarray(way / np.linalg.norm(way))


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))
