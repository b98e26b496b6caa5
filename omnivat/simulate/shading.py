"""A small shader of our own: VIS without a renderer, in numpy.

Parallel projection, one key light, a two-tone sky that shiny things mirror, glass that shows the
ground through its relief. It needs nothing installed; Mitsuba (vision.py) makes the real set.
"""

import numpy as np
from scipy.ndimage import gaussian_filter

from omnivat.simulate.contact import plane
from omnivat.simulate.framing import Framing
from omnivat.simulate.grounds import ground
from omnivat.simulate.noise import Array, smoothstep, turned
from omnivat.simulate.surfaces import Surface


def shaded(surface: Surface, framing: Framing, *, size: int) -> Array:
    """Return linear radiance (size, size, 3) of the surface under the framing."""
    x, y = plane(framing.view, size)
    x, y = x - framing.off[0], (y - framing.off[1]) / np.cos(framing.tilt)
    u, v = turned(x, y, framing.turn)
    along, across = turned(u, v, framing.axis)
    height = surface.height(u, v)
    normal = _normals(height, x, y)
    base = surface.colour(u + framing.at[0], v + framing.at[1])
    inside = outline(along, across, framing)
    behind = ground(framing.ground, x, y, seed=framing.seed)
    level = np.asarray(framing.sky) + np.asarray(framing.sun) * np.sin(framing.height) * 0.3
    backdrop = behind * level
    eye = np.array([0.0, -np.sin(framing.tilt), np.cos(framing.tilt)])
    shown = _reflected(surface, framing, normal, eye, base, x, y)
    shadow = gaussian_filter(inside, 0.03 * size)[..., None] * 0.45
    return np.asarray(inside[..., None] * shown + (1 - inside[..., None]) * backdrop * (1 - shadow))


def outline(u: Array, v: Array, framing: Framing) -> Array:
    """Return 1 on the object and 0 off it: a rectangle with rounded corners, or a disc."""
    half_u, half_v = framing.size[0] / 2, framing.size[1] / 2
    radius = framing.corner * min(half_u, half_v)
    away_u = np.maximum(np.abs(u) - half_u + radius, 0.0)
    away_v = np.maximum(np.abs(v) - half_v + radius, 0.0)
    pixel = framing.view / 224
    return 1.0 - smoothstep(np.hypot(away_u, away_v) - radius, -pixel, pixel)


def _normals(height: Array, x: Array, y: Array) -> Array:
    step_x, step_y = float(x[0, 1] - x[0, 0]), float(y[0, 0] - y[1, 0])
    down, right = np.gradient(height)
    normal = np.stack([-right / step_x, down / step_y, np.ones_like(height)], axis=-1)
    return np.asarray(normal / np.linalg.norm(normal, axis=-1, keepdims=True))


def _reflected(
    surface: Surface, framing: Framing, normal: Array, eye: Array, base: Array, x: Array, y: Array
) -> Array:
    """Return what leaves the surface towards the eye, (H, W, 3)."""
    flat = np.cos(framing.height)
    lamp = np.array(
        [flat * np.cos(framing.light), flat * np.sin(framing.light), np.sin(framing.height)]
    )
    sun, sky = np.asarray(framing.sun), np.asarray(framing.sky)
    lambert = np.maximum(normal @ lamp, 0.0)[..., None] * sun * 0.45 + sky
    half = (lamp + eye) / np.linalg.norm(lamp + eye)
    width = max(surface.roughness, 0.03) + 0.4 * framing.scene.softness
    facing = np.clip(normal @ half, 1e-3, 1.0)
    gloss = np.exp(-(1 / facing**2 - 1) / width**2)[..., None] * sun * 0.12 / width**1.2
    mirror = 2 * (normal @ eye)[..., None] * normal - eye
    up = smoothstep(mirror[..., 1], -0.4 - surface.roughness, 0.4 + surface.roughness)[..., None]
    environment = sky * (0.35 + 1.5 * up)
    fresnel = 0.04 + 0.96 * (1 - np.clip(normal @ eye, 0, 1)[..., None]) ** 5
    if surface.gloss == "matte":
        return np.asarray(base * lambert)
    if surface.gloss == "metal":
        return np.asarray(base * (1.4 * environment + 4.0 * gloss + 0.25 * lambert))
    if surface.gloss == "coated":
        return np.asarray(base * lambert + fresnel * environment + gloss)
    bent = 6.0 * normal[..., :2]
    behind = ground(framing.ground, x - bent[..., 0], y - bent[..., 1], seed=framing.seed)
    milky = min(surface.roughness * 2.0, 0.8)
    through = (1 - milky) * behind * base + milky * 0.55 * base
    return np.asarray(through * (0.8 * lambert) + fresnel * environment * 2.0 + 1.5 * gloss)
