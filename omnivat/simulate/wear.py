"""Variation between gels and days of one sensor: tint, lamps, gain, markers, wear."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter

from omnivat.simulate.contact import plane
from omnivat.simulate.noise import Array, noise, smoothstep
from omnivat.simulate.sensors import Colour, Lamp, Markers, Sensor

_TINT = 0.07  # spread of the gel's colour
_LAMP = 0.14  # spread of a lamp's strength
_AIM = 4.0  # degrees of spread in a lamp's direction


def used(sensor: Sensor, rng: np.random.Generator) -> Sensor:
    """Return the sensor with one particular gel, on one day."""
    lamps = tuple(
        Lamp(
            azimuth=lamp.azimuth + float(rng.normal(0, _AIM)),
            colour=_varied(lamp.colour, _LAMP, rng),
            spill=lamp.spill * float(rng.uniform(0.8, 1.2)),
        )
        for lamp in sensor.lamps
    )
    return replace(
        sensor,
        lamps=lamps,
        base=_varied(sensor.base, _TINT, rng),
        gain=sensor.gain * float(rng.uniform(0.85, 1.2)),
        skin=sensor.skin * float(rng.uniform(0.85, 1.2)),
        noise=sensor.noise * float(rng.uniform(0.6, 1.4)),
        markers=_printed(sensor, rng),
    )


def _varied(colour: Colour, spread: float, rng: np.random.Generator) -> Colour:
    """Return a colour whose strength and whose channels differ a little."""
    red, green, blue = np.exp(rng.normal(0, spread) + rng.normal(0, spread / 2, 3)) * colour
    return (float(red), float(green), float(blue))


def _printed(sensor: Sensor, rng: np.random.Generator) -> Markers | None:
    """Return the markers of one gel: shifted, worn, or missing."""
    plain, worn, print_ = rng.random(), float(rng.uniform(0.6, 1.05)), rng.uniform(-1, 1, 3)
    if sensor.markers is None or plain < sensor.plain_gels:
        return None
    return replace(
        sensor.markers,
        darkness=min(sensor.markers.darkness * worn, 1.0),
        radius=sensor.markers.radius * float(rng.uniform(0.85, 1.15)),
        shift=(float(print_[0]), float(print_[1])),
        turn=0.06 * float(print_[2]),
    )


def blotted(image: Array, sensor: Sensor, *, seed: int) -> Array:
    """Return the picture (size, size, 3) through a gel with stains and specks."""
    size = len(image)
    x, y = plane(sensor.field, size)
    rng = np.random.default_rng(seed)
    stains = 1.0 + 0.035 * noise(x, y, wavelength=5.0, seed=int(rng.integers(2**31)))
    specks = np.zeros((size, size))
    for _ in range(int(rng.integers(0, 7))):
        u, v = rng.uniform(-sensor.field / 2, sensor.field / 2, 2)
        radius = rng.uniform(0.05, 0.16)
        specks = np.maximum(specks, 1.0 - smoothstep(np.hypot(x - u, y - v), radius, 2 * radius))
    soft = gaussian_filter(specks, 0.5)
    return np.asarray(image * (stains * (1.0 - 0.6 * soft))[..., None])
