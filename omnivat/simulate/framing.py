"""Draw one photograph's circumstances from its domain's row, before any renderer is chosen."""

from dataclasses import dataclass

import numpy as np

from omnivat.simulate.scenes import Colour, Scene
from omnivat.simulate.surfaces import Surface

_WIDEST = 1.75  # width of a curved object, in radii of its curvature
_ROOM = 42.0  # mm: a narrower object would be hidden by the sensor
_OFTEN = 0.3  # of the pictures show the sensor
_LEAST_SHARE = 0.5  # of the view that an object's narrower side takes


@dataclass(frozen=True, slots=True, kw_only=True)
class Framing:
    """Where the camera and the light stand for one photograph; angles in rad, lengths in mm."""

    scene: Scene
    view: float
    size: tuple[float, float]  # of the object, along and across its axis
    axis: float  # of the object, in its own coordinates: its grain, or the axis of a cylinder
    corner: float  # share of the object's half-width that is rounded: 0 a card, 1 a disc
    at: tuple[float, float]  # contact, on the object
    off: tuple[float, float]  # where the contact lies from the picture's middle
    tilt: float
    turn: float  # of the camera about the surface's normal
    light: float  # direction of the key light
    height: float  # of the key light
    sun: Colour
    sky: Colour
    ground: str
    held: bool  # whether the sensor stands on the contact while the picture is taken
    seed: int


def framed(
    scene: Scene, surface: Surface, *, at: tuple[float, float], part: str, seed: int
) -> Framing:
    """Return the framing of one photograph. Outdoors (`part`) is brighter and bluer.

    An object that curves is no wider than its curvature allows, and the camera comes closer to it.
    """
    rng = np.random.default_rng(seed)
    view = float(rng.uniform(*scene.view))
    length = view * float(rng.uniform(*scene.extent))
    form = surface.form
    length = min(length, _WIDEST / max(form.along, 1e-9))
    width = min(length * float(rng.uniform(0.6, 1.0)), _WIDEST / max(form.across, 1e-9))
    view = min(view, width / _LEAST_SHARE)
    strength = float(rng.uniform(0.8, 1.2))
    day = (1.25, 1.3, 1.45) if part == "outdoor" else (1.0, 1.0, 1.0)
    held = bool(scene.prop) and width > _ROOM and bool(rng.random() < _OFTEN)
    off = rng.uniform(-1, 1, 2) * view * (0.24 if held else 0.08)
    grounds = ("paving",) if part == "outdoor" else scene.ground
    return Framing(
        scene=scene,
        view=view,
        size=(length, width),
        axis=surface.axis,
        corner=float(rng.choice([0.06, 0.25, 1.0], p=[0.5, 0.3, 0.2])),
        at=at,
        off=(float(off[0]), float(off[1])),
        tilt=float(np.deg2rad(rng.uniform(*scene.tilt))),
        turn=surface.axis + float(rng.uniform(-0.6, 0.6)),
        light=float(rng.uniform(0, 2 * np.pi)),
        height=float(np.deg2rad(rng.uniform(*scene.height))),
        sun=_scaled(scene.sun, strength, (1.0, 1.0, 1.0)),
        sky=_scaled(scene.sky, 1.0, day),
        ground=str(rng.choice(grounds)),
        held=held,
        seed=seed,
    )


def _scaled(colour: Colour, strength: float, tint: Colour) -> Colour:
    red, green, blue = (float(c * strength * t) for c, t in zip(colour, tint, strict=True))
    return (red, green, blue)
