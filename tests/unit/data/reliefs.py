"""Reliefs whose slopes and lamps are known, as a gel with coloured lamps shows them."""

import numpy as np
from scipy.ndimage import gaussian_filter

LIT = np.array([[26.0, 2.0], [-14.0, 22.0], [-12.0, -25.0]])  # colours of 255 by slope, as `Lamps`


def pressed(rng, height=112, width=112):
    """A gel's heights over random waves: pushed by their crests, bridging their hollows."""
    y, x = np.mgrid[:height, :width] * (112 / min(height, width))
    waves = rng.normal(size=(6, 4)) * [0.13, 0.13, 3, 1]
    thing = sum(size * np.cos(a * x + b * y + c) for a, b, c, size in waves) * 3
    indent = sheet = np.maximum(thing - np.quantile(thing, 0.3), 0)
    for reach in (8, 4, 2, 1):
        sheet = np.maximum(indent, gaussian_filter(sheet, reach * min(height, width) / 112))
    return gaussian_filter(sheet, min(height, width) / 112)


def shown(sheet, lit=LIT, light=128.0, grain=None):
    """The picture (H, W, 3) uint8 of heights under lamps, its slopes of mean square 1."""
    down, right = np.gradient(sheet)
    slopes = np.stack([right, down], -1)
    slopes /= np.sqrt(np.square(slopes).mean())
    noise = 0 if grain is None else grain.normal(0, 2, (*sheet.shape, 3))
    return np.clip(np.rint(light + slopes @ lit.T + noise), 0, 255).astype(np.uint8)


def touches(seed, count, lit=LIT, side=112, light=128.0):
    rng = np.random.default_rng(seed)
    return [shown(pressed(rng, side, side), lit, light, rng) for _ in range(count)]


def cosine(a, b):
    return float((a * b).sum() / np.linalg.norm(a) / np.linalg.norm(b))
