"""The built-in shader: VIS without a renderer, in numpy.

Points on the object are projected and shaded by one key light and a two-tone sky; each pixel keeps
the nearest. It has no dependencies; Mitsuba (vision.py) makes the shipped set.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from omnivat.simulate.framing import Framing
from omnivat.simulate.grounds import beyond, ground
from omnivat.simulate.noise import Array, smoothstep
from omnivat.simulate.surfaces import Surface
from omnivat.simulate.things import Thing

_POINTS = 12  # for each pixel


def shaded(thing: Thing, framing: Framing, *, size: int) -> Array:
    """Return linear radiance (size, size, 3) of the thing under the framing."""
    axes = _axes(framing)
    image = _around(framing, axes, size)
    points, normals, uv = _scattered(thing, _POINTS * size * size, framing.seed)
    row, column, depth = _projected(points, framing, axes, size)
    facing = ((framing.eye - points) * normals).sum(1) > 0
    inside = facing & (depth > 0) & (row >= 0) & (row < size) & (column >= 0) & (column < size)
    order = np.flatnonzero(inside)[np.argsort(-depth[inside])]  # the nearest is written last
    shown = _reflected(thing.sight, framing, points[order], normals[order], uv[order])
    cell = row[order] * size + column[order]
    image.reshape(-1, 3)[cell] = shown
    return _closed(image, np.bincount(cell, minlength=size * size).reshape(size, size) > 0)


def _axes(framing: Framing) -> Array:
    """Return right, up and ahead (3, 3) of the camera."""
    ahead = framing.target - framing.eye
    ahead = ahead / np.linalg.norm(ahead)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right = right / max(float(np.linalg.norm(right)), 1e-9)
    return np.stack([right, np.cross(right, ahead), ahead])


def _scattered(thing: Thing, count: int, seed: int) -> tuple[Array, Array, Array]:
    """Return points (N, 3), evenly over the solid, with normals and uv."""
    solid, rng = thing.solid, np.random.default_rng(seed)
    corner = solid.vertices[solid.faces]
    across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    area = np.linalg.norm(across, axis=1)
    face = rng.choice(len(area), size=count, p=area / area.sum())
    one, two = rng.random((2, count))
    flip = one + two > 1.0
    one, two = np.where(flip, 1 - one, one), np.where(flip, 1 - two, two)
    share = np.stack([1 - one - two, one, two], axis=1)
    normal = np.einsum("nk,nkd->nd", share, solid.normals()[solid.faces[face]])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    return (
        np.einsum("nk,nkd->nd", share, corner[face]), normal,
        np.einsum("nk,nkd->nd", share, solid.uv[solid.faces[face]]),
    )  # fmt: skip


def _projected(points: Array, framing: Framing, axes: Array, size: int) -> tuple[Array, ...]:
    """Return row, column (whole numbers) and depth (mm) of points (N, 3) in the picture."""
    x, y, depth = ((points - framing.eye) @ axes.T).T
    scale = size / 2 / np.tan(framing.lens / 2) / np.maximum(depth, 1e-6)
    return (
        np.floor(size / 2 - y * scale).astype(int), np.floor(size / 2 + x * scale).astype(int),
        depth,
    )  # fmt: skip


def _around(framing: Framing, axes: Array, size: int) -> Array:
    """Return the picture (size, size, 3) without the object: ground below, background above."""
    axis = ((np.arange(size) + 0.5) / size * 2 - 1) * np.tan(framing.lens / 2)
    right, up = np.meshgrid(axis, -axis)
    way = right[..., None] * axes[0] + up[..., None] * axes[1] + axes[2]
    light = np.asarray(framing.sky) + np.asarray(framing.sun) * np.sin(framing.height) * 0.3
    down = way[..., 2] < -1e-3
    reach = np.clip(framing.eye[2] / np.maximum(-way[..., 2], 1e-3), 0.0, 20.0 * framing.view)
    place = framing.eye + reach[..., None] * way
    under = ground(framing.ground, place[..., 0], place[..., 1], seed=framing.seed)
    wide = framing.eye + 2.0 * framing.view * way
    over = (
        beyond(framing.behind, wide[..., 0], wide[..., 2], seed=framing.seed + 4)
        if framing.behind
        else under
    )
    return np.asarray(np.where(down[..., None], under, over) * light)


def _reflected(
    surface: Surface, framing: Framing, points: Array, normal: Array, uv: Array
) -> Array:
    """Return the radiance (N, 3) of surface points (N, 3) towards the eye."""
    base = surface.colour(uv[:, 0], uv[:, 1])
    eye = framing.eye - points
    eye = eye / np.linalg.norm(eye, axis=1, keepdims=True)
    flat = np.cos(framing.height)
    lamp = np.array(
        [flat * np.cos(framing.light), flat * np.sin(framing.light), np.sin(framing.height)]
    )
    sun, sky = np.asarray(framing.sun), np.asarray(framing.sky)
    lambert = np.maximum(normal @ lamp, 0.0)[:, None] * sun * 0.45 + sky
    half = (lamp + eye) / np.linalg.norm(lamp + eye, axis=1, keepdims=True)
    width = max(surface.roughness, 0.03) + 0.4 * framing.scene.softness
    toward = np.clip((normal * half).sum(1), 1e-3, 1.0)
    gloss = np.exp(-(1 / toward**2 - 1) / width**2)[:, None] * sun * 0.12 / width**1.2
    facing = np.clip((normal * eye).sum(1), 0.0, 1.0)[:, None]
    mirror = 2 * facing * normal - eye
    sharp = 0.4 + surface.roughness
    environment = sky * (0.35 + 1.5 * smoothstep(mirror[:, 2], -sharp, sharp)[:, None])
    fresnel = 0.04 + 0.96 * (1 - facing) ** 5
    if surface.gloss == "matte":
        return np.asarray(base * lambert)
    if surface.gloss == "metal":
        return np.asarray(base * (1.4 * environment + 4.0 * gloss + 0.25 * lambert))
    if surface.gloss == "coated":
        return np.asarray(base * lambert + fresnel * environment + gloss)
    return np.asarray(0.5 * base * lambert + 2.0 * fresnel * environment + 1.5 * gloss)


def _closed(image: Array, hit: NDArray[np.bool_]) -> Array:
    """Return the picture with empty pixels filled from neighbours on the object."""
    near = distance_transform_edt(~hit, return_distances=True, return_indices=True)
    away, (row, column) = near
    holes = (~hit) & (away < 1.5) & (_neighbours(hit) >= 5)
    return np.asarray(np.where(holes[..., None], image[row, column], image))


def _neighbours(hit: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the number of filled pixels in each 3 × 3 neighbourhood."""
    padded = np.pad(hit.astype(np.int64), 1)
    shifted = [
        padded[1 + i : padded.shape[0] - 1 + i, 1 + j : padded.shape[1] - 1 + j]
        for i in (-1, 0, 1)
        for j in (-1, 0, 1)
    ]
    return np.asarray(np.sum(shifted, axis=0))
