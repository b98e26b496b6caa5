"""Draw one photograph's circumstances from its domain's row, before any renderer is chosen."""

from dataclasses import dataclass

import numpy as np

from omnivat.simulate.scenes import Colour, Scene


@dataclass(frozen=True, slots=True, kw_only=True)
class Framing:
    """Where the camera and the light stand for one photograph; angles in rad, lengths in mm."""

    scene: Scene
    view: float
    size: tuple[float, float]  # of the object
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
    seed: int


def framed(scene: Scene, *, at: tuple[float, float], part: str, seed: int) -> Framing:
    """Return the framing of one photograph. Outdoors (`part`) is brighter, bluer and harder."""
    rng = np.random.default_rng(seed)
    view = float(rng.uniform(*scene.view))
    width = view * float(rng.uniform(*scene.extent))
    strength = float(rng.uniform(0.8, 1.2))
    day = (1.25, 1.3, 1.45) if part == "outdoor" else (1.0, 1.0, 1.0)
    off = rng.uniform(-0.08, 0.08, 2) * view
    grounds = ("paving", "grass") if part == "outdoor" else scene.ground
    return Framing(
        scene=scene,
        view=view,
        size=(width, width * float(rng.uniform(0.6, 1.0))),
        corner=float(rng.choice([0.06, 0.25, 1.0], p=[0.5, 0.3, 0.2])),
        at=at,
        off=(float(off[0]), float(off[1])),
        tilt=float(np.deg2rad(rng.uniform(*scene.tilt))),
        turn=float(rng.uniform(0, 2 * np.pi)),
        light=float(rng.uniform(0, 2 * np.pi)),
        height=float(np.deg2rad(rng.uniform(*scene.height))),
        sun=_scaled(scene.sun, strength, (1.0, 1.0, 1.0)),
        sky=_scaled(scene.sky, 1.0, day),
        ground=str(rng.choice(grounds)),
        seed=seed,
    )


def _scaled(colour: Colour, strength: float, tint: Colour) -> Colour:
    red, green, blue = (float(c * strength * t) for c, t in zip(colour, tint, strict=True))
    return (red, green, blue)
