"""VIS by Mitsuba 3: the object in its place, its surroundings, the camera, and a denoiser.

Denoising is an edge-avoiding à-trous filter (Dammertz et al., 2010) on light divided by the
surface's colour, which keeps textures sharp.
"""

from itertools import product
from typing import Any

import numpy as np
from scipy.ndimage import median_filter, uniform_filter

from simulator.noise import Array, direction, octaves, smoothstep
from simulator.photograph import Framing
from simulator.props import props
from simulator.renderer import mitsuba
from simulator.staging import clutter, material, mesh, place, textured
from simulator.things import Thing

SAMPLES = 4  # paths for each pixel; their grain is filtered
SAMPLES_GLASS = 8
_GUIDES = 2  # rays for each pixel for its colour and normal


def rendered(thing: Thing, framing: Framing, *, size: int) -> Array:
    """Return linear radiance (size, size, 3) of the thing under the framing.

    Raises MissingPackageError without mitsuba.
    """
    mi = mitsuba()
    texture = textured(thing, framing)
    clear = thing.sight.gloss == "glass"
    depth, samples = (9, SAMPLES_GLASS) if clear else (3, SAMPLES)
    # Light through clear glass is found by chance, so a small lamp would sparkle.
    sky = panorama(framing, least_softness=0.6 if clear else 0.0).astype(np.float32)
    upright = mi.ScalarTransform4f().rotate([1, 0, 0], 90)
    whole = props(framing) | place(thing, framing) | clutter(thing, framing)
    scene = mi.load_dict(whole | {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": depth, "rr_depth": 6},
        "sensor": _camera(framing, size, samples),
        "light": {"type": "envmap", "bitmap": mi.Bitmap(sky), "to_world": upright},
        "object": mesh(thing.solid, texture.uv, material(thing, texture)),
    })  # fmt: skip
    seed = framing.seed % 2**31
    image = mi.render(scene, spp=samples, seed=seed)
    radiance = np.clip(_pixels(image)[..., :3], 0.0, 5.0)
    if clear:  # each path is reflected or transmitted, so single pixels stand out
        radiance = np.asarray(median_filter(radiance, size=(3, 3, 1), mode="nearest"))
    guides = mi.load_dict({"type": "aov", "aovs": "colour:albedo,normal:sh_normal"})
    guide = _pixels(mi.render(scene, spp=_GUIDES, seed=seed, integrator=guides))
    return denoised(radiance, guide[..., :3], guide[..., 3:6])


def _pixels(image: Any) -> Array:
    """Return an image's values; a path through a degenerate triangle counts as dark."""
    return np.nan_to_num(np.asarray(image, dtype=np.float64), nan=0.0, posinf=5.0, neginf=0.0)


def _camera(framing: Framing, size: int, samples: int) -> dict[str, Any]:
    """Return Mitsuba's description of a camera for a framing."""
    view = (
        mitsuba()
        .ScalarTransform4f()
        .look_at(origin=framing.eye.tolist(), target=framing.target.tolist(), up=[0, 0, 1])
    )
    return {
        "type": "perspective",
        "fov": float(np.rad2deg(framing.lens)),
        "to_world": view,
        "film": {
            "type": "hdrfilm",
            "width": size,
            "height": size,
            "pixel_format": "rgb",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent", "sample_count": samples},
    }


_STEPS = (1, 2, 4)  # pixels between the taps of each pass
_COLOUR, _NORMAL = 0.06, 0.25  # differences above which two pixels count as different
_LIGHT = (0.9, 0.5, 0.3)  # the same for the logarithm of light, at each pass
_FLOOR = 0.03  # smallest reflectance for dividing light by colour


def denoised(radiance: Array, colour: Array, normal: Array) -> Array:
    """Return radiance (H, W, 3) without grain.

    colour  (H, W, 3) reflectance of what each pixel shows
    normal  (H, W, 3) of what each pixel shows
    """
    body = colour + _FLOOR
    light = radiance / body
    for step, spread in zip(_STEPS, _LIGHT, strict=True):
        light = _smoothed(light, colour, normal, step, spread)
    return light * body


def _smoothed(light: Array, colour: Array, normal: Array, step: int, spread: float) -> Array:
    """Return the light (H, W, 3), averaged within edges of colour, normal and tone."""
    # Compare means of nine pixels: a single dark or bright path is not an edge.
    tone = np.log(uniform_filter(light.mean(-1), 3, mode="nearest") + 0.02)
    features = np.concatenate([colour / _COLOUR, normal / _NORMAL, tone[..., None] / spread], -1)
    total, weights = np.zeros_like(light), np.zeros(light.shape[:2])
    pad = [(step, step), (step, step), (0, 0)]
    wide, around = np.pad(light, pad, mode="edge"), np.pad(features, pad, mode="edge")
    rows, columns = light.shape[:2]
    for down, right in product((0, step, 2 * step), repeat=2):
        there = (slice(down, down + rows), slice(right, right + columns))
        apart = around[there] - features
        near = 0.5 ** (abs(down - step) // step + abs(right - step) // step)
        weight = near * np.exp(-0.5 * np.einsum("hwc,hwc->hw", apart, apart))
        total += weight[..., None] * wide[there]
        weights += weight
    return total / weights[..., None]


_ROWS, _COLUMNS = 64, 128


def panorama(framing: Framing, *, least_softness: float) -> Array:
    """Return radiance (64, 128, 3) by polar angle from straight up, and azimuth.

    Shiny objects mirror their surroundings, so the sky has a horizon and walls or clouds. The key
    light's total power does not depend on its size.
    """
    down = (np.arange(_ROWS) + 0.5) / _ROWS * np.pi
    around = (np.arange(_COLUMNS) + 0.5) / _COLUMNS * 2 * np.pi
    polar, azimuth = np.meshgrid(down, around, indexing="ij")
    way = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1
    )
    key = direction(framing.light, framing.height)
    width = max(framing.scene.softness, least_softness, 0.08)
    away = np.arccos(np.clip(way @ key, -1.0, 1.0))
    lamp = np.exp(-((away / width) ** 4))
    weight = np.sin(polar)
    lamp = lamp / (lamp * weight).sum() * _ROWS * _COLUMNS / np.pi**2
    x, y = 3.0 * way[..., 0] + way[..., 2], 3.0 * way[..., 1]
    blocks = octaves(x, y, framing.seed, wavelength=1.5, finest=0.4)
    bright = 0.2 + 0.8 * smoothstep(np.cos(polar), -0.05, 0.25)
    bright *= 1.0 + 0.8 * np.tanh(2.0 * blocks)
    return framing.sky * bright[..., None] + 1.3 * framing.sun * lamp[..., None]
