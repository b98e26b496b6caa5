"""Environment light of a scene, as a small panorama of radiance: sky or room, and the key light."""

import numpy as np

from omnivat.simulate.framing import Framing
from omnivat.simulate.noise import Array, octaves, smoothstep

_ROWS, _COLUMNS = 64, 128


def panorama(framing: Framing, *, least_softness: float = 0.0) -> Array:
    """Return radiance (64, 128, 3) by polar angle from straight up, and azimuth.

    Shiny objects mirror their surroundings, so the sky has a horizon and walls or clouds. The key
    light's total power does not depend on its size.
    """
    polar, azimuth = np.meshgrid(
        (np.arange(_ROWS) + 0.5) / _ROWS * np.pi,
        (np.arange(_COLUMNS) + 0.5) / _COLUMNS * 2 * np.pi,
        indexing="ij",
    )
    way = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1
    )
    flat = np.cos(framing.height)
    key = np.array(
        [flat * np.cos(framing.light), flat * np.sin(framing.light), np.sin(framing.height)]
    )
    width = max(framing.scene.softness, least_softness, 0.08)
    away = np.arccos(np.clip(way @ key, -1.0, 1.0))
    lamp = np.exp(-((away / width) ** 4))
    weight = np.sin(polar)
    lamp = lamp / (lamp * weight).sum() * _ROWS * _COLUMNS / np.pi**2
    sky = np.asarray(framing.sky) * _surroundings(way, polar, framing.seed)[..., None]
    return np.asarray(sky + 1.3 * np.asarray(framing.sun) * lamp[..., None])


def _surroundings(way: Array, polar: Array, seed: int) -> Array:
    """Return the uneven brightness of the surroundings, about 1."""
    above = smoothstep(np.cos(polar), -0.05, 0.25)
    blocks = octaves(
        3.0 * way[..., 0] + way[..., 2], 3.0 * way[..., 1], wavelength=1.5, finest=0.4, seed=seed
    )
    return np.asarray((0.2 + 0.8 * above) * (1.0 + 0.8 * np.tanh(2.0 * blocks)))
