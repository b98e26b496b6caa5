"""The set of a photograph: ground, background, other things."""

from typing import Any

import numpy as np

from omnivat.simulate.framing import Framing
from omnivat.simulate.grounds import beyond, ground
from omnivat.simulate.noise import Array
from omnivat.simulate.props import others
from omnivat.simulate.reflecting import bitmap, mesh
from omnivat.simulate.things import Thing

_PIXELS = 160  # of the grounds' pictures
_SIDE = 4.0  # of the ground, in widths of the view
_PLAIN = 40.0  # the same where nothing is seen beyond it
_TURNTABLE = (0.62, 1.1)  # radius, in extents of the object
_STEP_DOWN = 14.0  # mm from the turntable to the cloth


def place(mi: Any, thing: Thing, framing: Framing) -> dict[str, Any]:
    """Return the ground, the background, and the turntable if there is one."""
    clear = thing.sight.gloss == "glass"
    half = (_SIDE if framing.behind else _PLAIN) * max(framing.view, 300.0) / 2
    middle = np.array([framing.target[0], framing.target[1], -0.3])
    transform = mi.ScalarTransform4f()
    shapes: dict[str, Any] = {}
    if framing.ground == "turntable":
        radius = float(np.random.default_rng(framing.seed + 3).uniform(*_TURNTABLE))
        radius *= _extent(thing)
        disc = {"type": "disk", "to_world": transform.translate([0, 0, -0.3]).scale(radius)}
        rim = {"type": "cylinder", "p0": [0, 0, -_STEP_DOWN], "p1": [0, 0, -0.3], "radius": radius}
        tone = np.full((2, 2, 3), 0.82)
        shapes |= {"top": disc | _shown(mi, tone, framing, clear)}
        shapes |= {"rim": rim | _shown(mi, 0.8 * tone, framing, clear)}
        middle[2] = -_STEP_DOWN
    axis = np.linspace(-half, half, _PIXELS)
    x, y = np.meshgrid(axis, axis)
    flat = transform.translate(middle.tolist()).scale([half, half, 1])
    colour = ground(framing.ground, x, y, seed=framing.seed)
    shapes["ground"] = {"type": "rectangle", "to_world": flat} | _shown(mi, colour, framing, clear)
    if framing.behind:
        shapes["behind"] = _backdrop(mi, framing, clear)
    return shapes


def _backdrop(mi: Any, framing: Framing, clear: bool) -> dict[str, Any]:
    far = (framing.target - framing.eye) * [1.0, 1.0, 0.0]
    far = far / max(float(np.linalg.norm(far)), 1e-6)
    middle = framing.target * [1.0, 1.0, 0.0] + framing.away * far
    half = 1.6 * (framing.view + framing.away)
    axis = np.linspace(-half, half, _PIXELS)
    x, z = np.meshgrid(axis, axis + half)
    colour = beyond(framing.behind, x, z, seed=framing.seed + 4)
    centre = middle + np.array([0.0, 0.0, half - 15.0])
    stand = mi.ScalarTransform4f().look_at(
        origin=centre.tolist(), target=(centre - far).tolist(), up=[0, 0, 1]
    )
    return {"type": "rectangle", "to_world": stand.scale([half, half, 1])} | _shown(
        mi, colour, framing, clear
    )


def _shown(mi: Any, colour: Array, framing: Framing, clear: bool) -> dict[str, Any]:
    """Return the material of a ground; behind clear glass it emits light.

    Under glass, few paths reach the lamp.
    """
    if clear:
        lit = colour * (np.asarray(framing.sky) + 0.35 * np.asarray(framing.sun)) * 0.8
        glow = {"type": "area", "radiance": bitmap(mi, lit)}
        return {"emitter": glow, "bsdf": {"type": "diffuse", "reflectance": 0.0}}
    plain = {"type": "diffuse", "reflectance": bitmap(mi, colour)}
    return {"bsdf": {"type": "twosided", "bsdf": plain}}


def clutter(mi: Any, thing: Thing, framing: Framing) -> dict[str, Any]:
    """Return other things about the object."""
    shapes: dict[str, Any] = {}
    for index, (solid, bsdf) in enumerate(others(framing, extent=_extent(thing))):
        shapes[f"other{index}"] = mesh(mi, solid, np.zeros((len(solid.vertices), 2)), bsdf)
    return shapes


def _extent(thing: Thing) -> float:
    """Return the diagonal of the ground that the object takes, mm."""
    return float(np.linalg.norm(np.ptp(thing.solid.vertices, axis=0)[:2]))
