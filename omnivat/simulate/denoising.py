"""Denoise a render of few paths: average light between similar neighbours.

This is an edge-avoiding à-trous filter (Dammertz et al., 2010) on light divided by the surface's
colour, which keeps textures sharp.
"""

import numpy as np
from scipy.ndimage import uniform_filter

from omnivat.simulate.noise import Array

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
    return np.asarray(light * body)


def _smoothed(light: Array, colour: Array, normal: Array, step: int, spread: float) -> Array:
    # Compare means of nine pixels: a single dark or bright path is not an edge.
    tone = np.log(uniform_filter(light.mean(-1), 3, mode="nearest") + 0.02)
    features = np.concatenate([colour / _COLOUR, normal / _NORMAL, tone[..., None] / spread], -1)
    total, weights = np.zeros_like(light), np.zeros(light.shape[:2])
    pad = [(step, step), (step, step), (0, 0)]
    wide, around = np.pad(light, pad, mode="edge"), np.pad(features, pad, mode="edge")
    rows, columns = light.shape[:2]
    for down in (0, step, 2 * step):
        for right in (0, step, 2 * step):
            there = (slice(down, down + rows), slice(right, right + columns))
            apart = around[there] - features
            near = 0.5 ** (abs(down - step) // step + abs(right - step) // step)
            weight = near * np.exp(-0.5 * np.einsum("hwc,hwc->hw", apart, apart))
            total += weight[..., None] * wide[there]
            weights += weight
    return np.asarray(total / weights[..., None])
