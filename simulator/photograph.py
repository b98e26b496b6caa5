"""VIS: draw camera and light from the domain's scene, render, and photograph.

From radiance to a photograph: exposure, white balance, tone, softness, grain."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from omnivat.kit.seeding import derive_seed
from simulator.noise import Array, Rng, direction
from simulator.plan import Planned
from simulator.scenes import OUTDOORS, Scene
from simulator.shapes import Spot, blocked
from simulator.things import Thing, is_outdoors

_TRIED = 14  # tries for a camera position that sees the contact
_FACING = 0.2  # least cosine between the line of sight and the contact's normal
_LEAST = {"hand": 260.0, "rig": 150.0, "": 120.0}  # least mm in view
_DAY = (1.25, 1.3, 1.45)


@dataclass(frozen=True, slots=True, kw_only=True)
class Framing:
    """Camera and light of one photograph; angles in rad, lengths in mm."""

    scene: Scene
    spot: Spot  # the contact, which the camera sees
    eye: Array  # (3,)
    target: Array  # (3,) what the camera looks at
    view: float  # width of the picture at the target
    lens: float  # field of view
    light: float  # direction of the key light
    height: float  # of the key light
    sun: Array  # radiance of the key light, (3,)
    sky: Array  # of the light from everywhere
    ground: str
    behind: str  # background object, or ""
    away: float  # its distance behind the target
    held: bool  # True if the sensor is in the picture
    clutter: int  # other things on the ground
    seed: int


def framed(scene: Scene, thing: Thing, *, outdoors: bool, seed: int) -> Framing:
    """Return the framing of one photograph; outdoors is brighter and bluer."""
    rng = np.random.default_rng(seed)
    low, high = thing.solid.vertices.min(0), thing.solid.vertices.max(0)
    middle, extent = (low + high) / 2, float(np.linalg.norm(high - low))
    view = rng.uniform(*scene.view)
    lens = np.deg2rad(scene.lens * rng.uniform(0.9, 1.1))
    if scene.whole:
        view, target = view * extent, middle + rng.uniform(-0.04, 0.04, 3) * view * extent
    else:
        view = min(view, max(1.6 * extent, _LEAST[scene.prop]))
        share = rng.uniform(0.0, 0.35)
        target = thing.spot.point * (1 - share) + middle * share
        target = target + rng.uniform(-0.1, 0.1, 3) * view
    grounds, behind = OUTDOORS if outdoors else (scene.ground, scene.behind)
    strength = rng.uniform(0.75, 1.25)
    return Framing(
        scene=scene,
        spot=thing.spot,
        eye=_camera(scene, thing, target, view / 2 / np.tan(lens / 2), rng),
        target=target,
        view=view,
        lens=lens,
        light=rng.uniform(0, 2 * np.pi),
        height=np.deg2rad(rng.uniform(*scene.height)),
        sun=np.multiply(scene.sun, strength),
        sky=np.multiply(scene.sky, _DAY if outdoors else 1.0),
        ground=rng.choice(grounds),
        behind=rng.choice(behind) if behind else "",
        away=rng.uniform(0.7, 2.0) * max(view, extent),
        held=rng.random() < scene.seen,
        clutter=min(rng.poisson(scene.clutter), 2),
        seed=seed,
    )


def _camera(scene: Scene, thing: Thing, target: Array, distance: float, rng: Rng) -> Array:
    """Return a camera position that sees the contact, if one is found."""
    spot, best, most = thing.spot, target + np.array([0.0, -distance, distance]), -2.0
    steep = np.hypot(spot.normal[0], spot.normal[1]) > 0.4
    ahead = np.arctan2(spot.normal[1], spot.normal[0])
    for _ in range(_TRIED):
        turn = ahead + rng.normal(0, 0.6) if steep else rng.uniform(0, 2 * np.pi)
        rise = np.deg2rad(rng.uniform(*scene.rise))
        eye = target + distance * direction(turn, rise)
        eye[2] = max(eye[2], 25.0)
        sight = (eye - spot.point) / np.linalg.norm(eye - spot.point)
        facing = float(sight @ spot.normal)
        if facing > most:
            best, most = eye, facing
        if facing > _FACING and not blocked(thing.solid, spot.point + 0.3 * spot.normal, eye):
            return eye
    return best


Renderer = Callable[..., Array]


def photograph(thing: Thing, pair: Planned, stream: int, *, size: int, renderer: Renderer) -> Array:
    """Return VIS (size, size, 3), 0 to 1: the thing, with its touched place in view.

    stream  the pair's seed, from which framing and camera draw theirs
    """
    scene = pair.made.scene
    place = np.random.default_rng(derive_seed(stream, "place"))
    framing = framed(
        scene, thing, outdoors=is_outdoors(pair, place), seed=derive_seed(stream, "framing")
    )
    radiance = renderer(thing, framing, size=size)
    return exposed(radiance, scene, seed=derive_seed(stream, "camera"))


_GAIN = 2.0  # largest gain for dark pictures


def exposed(radiance: Array, scene: Scene, *, seed: int) -> Array:
    """Return the photograph (H, W, 3), 0 to 1, that the scene's camera takes of `radiance`."""
    rng = np.random.default_rng(seed)
    image = gaussian_filter(radiance, (scene.blur, scene.blur, 0.0), mode="nearest")
    image = image * scene.balance * (1.0 + scene.drift * rng.normal(size=3))
    bright = np.quantile(image.mean(-1), 0.9)
    goal = np.clip(scene.goal * rng.uniform(0.85, 1.2), 0.3, 0.9)
    # Automatic exposure is partial: dark things stay darker than bright ones.
    image = image * min((goal / max(bright, 1e-3)) ** 0.8, _GAIN)
    image = np.clip(image, 0.0, 1.6)
    shown = np.clip(image / (1.0 + 0.25 * image**2), 0.0, 1.0) ** (1 / 2.2)
    shown = 0.5 + (shown - 0.5) * scene.contrast
    grain = rng.normal(size=shown.shape) * scene.noise
    return np.clip(shown + grain, 0.0, 1.0)


def plain(thing: Thing, framing: Framing, *, size: int) -> Array:
    """Return the seen surface around the contact under even light, without a renderer.

    (size, size, 3) linear; it shows no shape, shadow or gloss. Tests of the pipeline use it.
    """
    axis = ((np.arange(size) + 0.5) / size - 0.5) * framing.view
    u, v = np.meshgrid(axis + framing.spot.uv[0], framing.spot.uv[1] - axis)
    light = framing.sky + np.sin(framing.height) * framing.sun
    return thing.sight.colour(u, v) * light
