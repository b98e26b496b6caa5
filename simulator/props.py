"""Other things in the picture: the sensor with its holder, and objects on the ground."""

from typing import Any

import numpy as np

from simulator.noise import Array, Colour, Rng, one_of
from simulator.photograph import Framing
from simulator.renderer import mitsuba
from simulator.shapes import KINDS, OBJECTS, kind_of, made_of
from simulator.shapes.solid import Solid, placed

_SKINS = ((0.52, 0.30, 0.21), (0.60, 0.38, 0.28), (0.35, 0.19, 0.12), (0.20, 0.10, 0.06))
_HOUSINGS = ((0.02, 0.02, 0.022), (0.02, 0.02, 0.022), (0.55, 0.55, 0.53), (0.16, 0.16, 0.17))
_GREY = (0.32, 0.32, 0.34)


def props(framing: Framing) -> dict[str, Any]:
    """Return Mitsuba shapes of the sensor on the contact, or nothing."""
    if not framing.held:
        return {}
    rng = np.random.default_rng(framing.seed + 1)
    return _hand(framing, rng) if framing.scene.prop == "hand" else _rig(framing, rng)


def _hand(framing: Framing, rng: Rng) -> dict[str, Any]:
    """Return the shapes of a hand that holds the sensor at the pressed spot, by name."""
    at, up = framing.spot.point, framing.spot.normal
    arm = _arm(framing, rng, lift=0.35)
    side = np.cross(up, arm)
    axes = np.stack([arm, side, up], axis=1)
    skin = one_of(_SKINS, rng)
    sleeve = (rng.uniform(0.015, 0.12) * rng.uniform(0.6, 1.6, 3)).tolist()
    shapes = {"housing": _rod(at + 0.3 * up, at + 62 * up, 12.0, _HOUSINGS[0])}
    palm = at + 44 * up + 30 * arm
    shapes["palm"] = _ball(palm, skin, axes, (30.0, 23.0, 15.0))
    for finger in range(4):
        middle = at + (20 + 9 * finger) * up + 14 * side + (4 - 3 * finger) * arm
        shapes[f"finger{finger}"] = _ball(middle, skin, axes, (26.0, 7.5, 6.5))
    thumb = at + 34 * up - 15 * side + 4 * arm
    shapes["thumb"] = _ball(thumb, skin, axes, (26.0, 8.0, 8.0))
    shapes["wrist"] = _rod(palm + 10 * arm, palm + 90 * arm, 20.0, skin)
    shapes["sleeve"] = _rod(palm + 65 * arm, palm + 700 * arm, 33.0, sleeve)
    return shapes


def _rig(framing: Framing, rng: Rng) -> dict[str, Any]:
    at, up = framing.spot.point, framing.spot.normal
    arm = _arm(framing, rng, lift=0.8)
    colour = one_of(_HOUSINGS, rng)
    top = at + 38 * up
    elbow = top + 120 * arm
    return {
        "gel": _rod(at + 0.3 * up, at + 7 * up, 10.0, (0.6, 0.6, 0.6)),
        "housing": _rod(at + 6 * up, top, 13.0, colour),
        "arm": _rod(top, elbow, 9.0, _GREY),
        "joint": _ball(elbow, _HOUSINGS[0], np.eye(3), (14.0,) * 3),
        "column": _rod(elbow, np.array([elbow[0], elbow[1], 700.0]), 12.0, _GREY),
    }


def _arm(framing: Framing, rng: Rng, *, lift: float) -> Array:
    """Return the unit direction of the arm from the sensor: sideways for the camera."""
    up = framing.spot.normal
    sight = framing.eye - framing.spot.point
    sight = sight / np.linalg.norm(sight)
    aside = np.cross(sight, up) * (1 if rng.random() < 0.7 else -1)
    aside /= max(float(np.linalg.norm(aside)), 1e-6)
    way = aside + rng.uniform(-0.2, 0.7) * sight + lift * up
    way[2] = max(way[2], -0.2)
    return way / np.linalg.norm(way)


def _rod(start: Array, end: Array, radius: float, colour: Colour) -> dict[str, Any]:
    """Return a closed cylinder between two points."""
    ends = {"p0": start.tolist(), "p1": end.tolist()}
    return {"type": "cylinder", **ends, "radius": radius, "bsdf": _plastic(colour)}


def _ball(middle: Array, colour: Colour, axes: Array, halves: tuple[float, ...]) -> dict[str, Any]:
    """Return an ellipsoid; axes (3, 3) are unit vectors as columns, halves their lengths, mm."""
    matrix = np.eye(4)
    matrix[:3, :3] = axes * halves
    matrix[:3, 3] = middle
    return {
        "type": "sphere",
        "to_world": mitsuba().ScalarTransform4f(matrix),
        "bsdf": _plastic(colour),
    }


def _plastic(colour: Colour) -> dict[str, Any]:
    reflectance = {"type": "rgb", "value": list(colour)}
    look = {"type": "roughplastic", "diffuse_reflectance": reflectance, "alpha": 0.3}
    return {"type": "twosided", "bsdf": look}


def others(framing: Framing, *, extent: float) -> list[tuple[Solid, dict[str, Any]]]:
    """Return other things on the ground, beyond the object, each with its material."""
    rng = np.random.default_rng(framing.seed + 2)
    far = framing.target - framing.eye
    away = np.arctan2(far[1], far[0])
    found = []
    for _ in range(framing.clutter):
        material = rng.choice(list(OBJECTS))
        solid = KINDS[kind_of(OBJECTS[material], rng)](rng, made_of(material, rng))
        turn = away + rng.normal(0, 0.8)
        reach = 0.55 * extent + rng.uniform(60, 200)
        middle = framing.target + reach * np.array([np.cos(turn), np.sin(turn), 0.0])
        moved = placed(solid, at=[*middle[:2], 0.0], turn=rng.uniform(0, 6.3))
        found.append((moved, _plastic(rng.uniform(0.03, 0.7, 3).tolist())))
    return found
