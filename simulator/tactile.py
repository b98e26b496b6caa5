"""A camera behind a gel lit by coloured lamps: from the gel's displacement to a tactile image.

A photometric-stereo model in four steps: slopes of the gel; light of each lamp on the slopes facing
it; appearance of the untouched gel; markers and camera errors.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter

from omnivat.kit.seeding import derive_seed
from simulator.contact import Press, pressed_gel
from simulator.noise import Array, Colour, Rng, noise, plane, smoothstep, turned
from simulator.sensors import Lamp, Markers, Sensor
from simulator.things import Thing


def touch(thing: Thing, press: Press, sensor: Sensor, *, size: int, seed: int) -> Array:
    """Return the tactile image (size, size, 3), 0 to 1, of one press.

    `seed` fixes the gel, its wear, and the noise.
    """
    sensor = used(sensor, np.random.default_rng(derive_seed(seed, "gel")))
    return imaged(pressed_gel(thing, press, sensor, size=size), sensor, press.shear, seed=seed)


def imaged(sheet: Array, sensor: Sensor, shear: Sequence[float], *, seed: int) -> Array:
    """Return the tactile image (size, size, 3), 0 to 1, of a pressed gel (size, size; mm)."""
    image = blotted(untouched(sensor, size=len(sheet)) + lit(sheet, sensor), sensor, seed=seed)
    image = _marked(image, sheet, sensor, shear)
    return photographed(image, blur=sensor.blur, grain=sensor.noise, seed=seed)


def at_rest(sensor: Sensor, *, size: int) -> Array:
    """Return the picture (size, size, 3), 0 to 1, of a new gel that touches nothing, without
    noise.
    """
    marked = _marked(untouched(sensor, size=size), np.zeros((size, size)), sensor, (0.0, 0.0))
    return photographed(marked, blur=sensor.blur)


def _marked(image: Array, sheet: Array, sensor: Sensor, shear: Sequence[float]) -> Array:
    """Return the picture with the gel's markers, if it has any."""
    if sensor.markers is None:
        return image
    return image * (1.0 - marker_shade(sheet, sensor.markers, sensor.field, shear)[..., None])


def untouched(sensor: Sensor, *, size: int) -> Array:
    """Return the image (size, size, 3) of the untouched gel: tint, spill, dark corners."""
    x, y = (axis * 2 / sensor.field for axis in plane(sensor.field, size))
    image = np.ones((size, size, 3)) * sensor.base
    for lamp in sensor.lamps:
        toward, _ = turned(x, y, np.deg2rad(lamp.azimuth))
        image += lamp.spill * toward[..., None] * lamp.colour * 0.55
    return image * (1.0 - sensor.vignette * 0.5 * (x**2 + y**2))[..., None]


def lit(sheet: Array, sensor: Sensor) -> Array:
    """Return the light of the gel's slopes (size, size; mm) in its picture, (size, size, 3)."""
    pixel = sensor.field / len(sheet)
    down, right = np.gradient(sheet, pixel)
    tilt = np.sqrt(1.0 + right**2 + down**2)
    # The sheet is pushed towards the camera; a slope faces the lamp that it leans away from.
    facing_x, facing_y = -right / tilt, down / tilt
    change = np.zeros((*sheet.shape, 3))
    for lamp in sensor.lamps:
        toward, _ = turned(facing_x, facing_y, np.deg2rad(lamp.azimuth))
        change += toward[..., None] * lamp.colour
    dimmed = (1.0 / tilt - 1.0)[..., None] * sensor.base
    return sensor.gain * 1.5 * np.tanh(change / 1.5) + 0.6 * dimmed


def marker_shade(sheet: Array, markers: Markers, field: float, shear: Sequence[float]) -> Array:
    """Return the darkness (0 to 1) of each pixel from printed dots, (size, size).

    Dots move with the gel: they spread away from the indentation and follow its shear.
    """
    x, y = plane(field, len(sheet))
    pixel = field / len(sheet)
    down, right = np.gradient(gaussian_filter(sheet, 0.6 / pixel, mode="nearest"), pixel)
    pushed = smoothstep(gaussian_filter(sheet, 1.5 / pixel, mode="nearest"), 0.0, 0.4)
    u, v = turned(
        x + 0.5 * right - shear[0] * pushed, y - 0.5 * down - shear[1] * pushed, markers.turn
    )
    u, v = u - markers.shift[0] * markers.pitch, v - markers.shift[1] * markers.pitch
    jitter = markers.uneven * markers.pitch
    u = u + jitter * noise(u, v, 11, wavelength=2.6 * markers.pitch)
    v = v + jitter * noise(u, v, 12, wavelength=2.6 * markers.pitch)
    radius = markers.radius * (
        1.0 + 2.0 * markers.uneven * noise(u, v, 13, wavelength=2.0 * markers.pitch)
    )
    du = u - np.round(u / markers.pitch) * markers.pitch
    dv = v - np.round(v / markers.pitch) * markers.pitch
    edge = 1.2 * pixel
    return markers.darkness * (1.0 - smoothstep(np.hypot(du, dv) - radius, -edge, edge))


def photographed(
    image: Array, *, blur: float, grain: float = 0.0, seed: int | None = None
) -> Array:
    """Return `image` (H, W, 3) as taken by a small camera: soft, grainy if it has a seed,
    clipped to 0 to 1.
    """
    image = gaussian_filter(image, (blur, blur, 0.0), mode="nearest")
    if seed is not None:
        rng = np.random.default_rng(seed)
        image = image * (1.0 + 0.03 * rng.normal()) + grain * rng.normal(size=image.shape)
    return np.clip(image, 0.0, 1.0)


# spread of the gel's colour, of a lamp's strength, of its direction in degrees
_TINT, _LAMP, _AIM = 0.07, 0.14, 4.0


def used(sensor: Sensor, rng: Rng) -> Sensor:
    """Return the sensor with one particular gel, on one day."""
    lamps = tuple(
        Lamp(
            lamp.azimuth + rng.normal(0, _AIM),
            _varied(lamp.colour, _LAMP, rng),
            lamp.spill * rng.uniform(0.8, 1.2),
        )
        for lamp in sensor.lamps
    )
    base = _varied(sensor.base, _TINT, rng)
    ranges = {"gain": (0.85, 1.2), "skin": (0.85, 1.2), "noise": (0.6, 1.4)}
    worn: dict[str, Any] = {
        name: getattr(sensor, name) * rng.uniform(*ends) for name, ends in ranges.items()
    }
    return replace(sensor, lamps=lamps, base=base, markers=_printed(sensor, rng), **worn)


def _varied(colour: Colour, spread: float, rng: Rng) -> Colour:
    """Return a colour whose strength and whose channels differ a little."""
    varied: Array = np.exp(rng.normal(0, spread) + rng.normal(0, spread / 2, 3)) * colour
    return varied


def _printed(sensor: Sensor, rng: Rng) -> Markers | None:
    """Return the markers of one gel: shifted, worn, or missing."""
    plain, worn = rng.random(), rng.uniform(0.6, 1.05)
    right, up, turn = rng.uniform(-1, 1, 3)
    if sensor.markers is None or plain < sensor.plain_gels:
        return None
    radius = sensor.markers.radius * rng.uniform(0.85, 1.15)
    dark = min(sensor.markers.darkness * worn, 1.0)
    return replace(
        sensor.markers, darkness=dark, radius=radius, shift=(right, up), turn=0.06 * turn
    )


def blotted(image: Array, sensor: Sensor, *, seed: int) -> Array:
    """Return the picture (size, size, 3) through a gel with stains and specks."""
    size = len(image)
    x, y = plane(sensor.field, size)
    rng = np.random.default_rng(seed)
    stains = 1.0 + 0.035 * noise(x, y, int(rng.integers(2**31)), wavelength=5.0)
    specks = np.zeros((size, size))
    for _ in range(rng.integers(0, 7)):
        u, v = rng.uniform(-sensor.field / 2, sensor.field / 2, 2)
        radius = rng.uniform(0.05, 0.16)
        specks = np.maximum(specks, 1.0 - smoothstep(np.hypot(x - u, y - v), radius, 2 * radius))
    return image * (stains * (1.0 - 0.6 * gaussian_filter(specks, 0.5)))[..., None]
