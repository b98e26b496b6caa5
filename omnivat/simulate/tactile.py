"""A camera behind a gel lit by coloured lamps: from the gel's displacement to a tactile image.

A photometric-stereo model in four steps: slopes of the gel; light of each lamp on the slopes facing
it; appearance of the untouched gel; markers and camera errors.
"""

import numpy as np
from scipy.ndimage import gaussian_filter

from omnivat.seeding import derive_seed
from omnivat.simulate.contact import Press, draped, indentation, plane, pressed_height
from omnivat.simulate.noise import Array, noise, smoothstep, turned
from omnivat.simulate.sensors import Lamp, Markers, Sensor
from omnivat.simulate.things import Thing
from omnivat.simulate.wear import blotted, used


def touch(thing: Thing, press: Press, sensor: Sensor, *, size: int, seed: int) -> Array:
    """Return the tactile image (size, size, 3), 0 to 1, of one press.

    `seed` fixes the gel, its wear, and the noise.
    """
    sensor = used(sensor, np.random.default_rng(derive_seed(seed, "gel")))
    height = pressed_height(thing, press, field=sensor.field, size=size)
    low, high = sensor.depth
    depth = low + press.depth * (high - low)
    indent = indentation(height, field=sensor.field, depth=depth, dome=sensor.dome)
    sheet = draped(indent, field=sensor.field, give=sensor.give, skin=sensor.skin)
    image = blotted(untouched(sensor, size=size) + lit(sheet, sensor), sensor, seed=seed)
    if sensor.markers:
        shade = marker_shade(sheet, sensor.markers, sensor.field, press.shear)
        image = image * (1.0 - shade[..., None])
    return photographed(image, blur=sensor.blur, noise_level=sensor.noise, seed=seed)


def untouched(sensor: Sensor, *, size: int) -> Array:
    """Return the image (size, size, 3) of the untouched gel: tint, spill, dark corners."""
    x, y = (axis * 2 / sensor.field for axis in plane(sensor.field, size))
    image = np.ones((size, size, 3)) * np.asarray(sensor.base)
    for lamp in sensor.lamps:
        image += lamp.spill * _toward(lamp, x, y)[..., None] * np.asarray(lamp.colour) * 0.55
    return np.asarray(image * (1.0 - sensor.vignette * 0.5 * (x**2 + y**2))[..., None])


def lit(sheet: Array, sensor: Sensor) -> Array:
    """Return the light of the gel's slopes (size, size; mm) in its picture, (size, size, 3)."""
    pixel = sensor.field / len(sheet)
    down, right = np.gradient(sheet, pixel)
    tilt = np.sqrt(1.0 + right**2 + down**2)
    # The sheet is pushed towards the camera; a slope faces the lamp that it leans away from.
    facing_x, facing_y = -right / tilt, down / tilt
    change = np.zeros((*sheet.shape, 3))
    for lamp in sensor.lamps:
        change += _toward(lamp, facing_x, facing_y)[..., None] * np.asarray(lamp.colour)
    dimmed = (1.0 / tilt - 1.0)[..., None] * np.asarray(sensor.base)
    return np.asarray(sensor.gain * 1.5 * np.tanh(change / 1.5) + 0.6 * dimmed)


def _toward(lamp: Lamp, x: Array, y: Array) -> Array:
    angle = np.deg2rad(lamp.azimuth)
    return np.asarray(x * np.cos(angle) + y * np.sin(angle))


def marker_shade(sheet: Array, markers: Markers, field: float, shear: tuple[float, float]) -> Array:
    """Return the darkness (0 to 1) of each pixel from printed dots, (size, size).

    Dots move with the gel: they spread away from the indentation and follow its shear.
    """
    size = len(sheet)
    x, y = plane(field, size)
    pixel = field / size
    down, right = np.gradient(gaussian_filter(sheet, 0.6 / pixel, mode="nearest"), pixel)
    pushed = smoothstep(gaussian_filter(sheet, 1.5 / pixel, mode="nearest"), 0.0, 0.4)
    u = x + 0.5 * right - shear[0] * pushed
    v = y - 0.5 * down - shear[1] * pushed
    u, v = turned(u, v, markers.turn)
    u, v = u - markers.shift[0] * markers.pitch, v - markers.shift[1] * markers.pitch
    jitter = markers.uneven * markers.pitch
    u = u + jitter * noise(u, v, wavelength=2.6 * markers.pitch, seed=11)
    v = v + jitter * noise(u, v, wavelength=2.6 * markers.pitch, seed=12)
    radius = markers.radius * (
        1.0 + 2.0 * markers.uneven * noise(u, v, wavelength=2.0 * markers.pitch, seed=13)
    )
    du = u - np.round(u / markers.pitch) * markers.pitch
    dv = v - np.round(v / markers.pitch) * markers.pitch
    edge = 1.2 * pixel
    return markers.darkness * (1.0 - smoothstep(np.hypot(du, dv) - radius, -edge, edge))


def photographed(image: Array, *, blur: float, noise_level: float, seed: int) -> Array:
    """Return `image` (H, W, 3) as taken by a small camera: soft, grainy, clipped to 0 to 1."""
    if blur:
        image = gaussian_filter(image, (blur, blur, 0.0), mode="nearest")
    rng = np.random.default_rng(seed)
    exposure = 1.0 + 0.03 * rng.normal()
    grainy = image * exposure + noise_level * rng.normal(size=image.shape)
    return np.asarray(np.clip(grainy, 0.0, 1.0))
