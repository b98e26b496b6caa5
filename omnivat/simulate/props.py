"""What else is in the picture: the sensor on the object, and the hand or clamp that holds it."""

from typing import Any

import numpy as np

from omnivat.simulate.framing import Framing

_HOUSING = 11.0  # mm, half-width of a sensor
_SKIN = (0.52, 0.30, 0.21)


def props(mi: Any, framing: Framing) -> dict[str, Any]:
    """Return Mitsuba shapes for what stands on the contact, or nothing."""
    rng = np.random.default_rng(framing.seed + 1)
    if not framing.held:
        return {}
    yaw, lean = float(rng.uniform(0, 360)), float(rng.uniform(-12, 12))
    upright = mi.ScalarTransform4f().rotate([0, 0, 1], yaw).rotate([1, 0, 0], lean)
    shapes = {"housing": _box(upright.translate([0, 0, 17]).scale([_HOUSING, _HOUSING, 16]), 0.03)}
    if framing.scene.prop == "clamp":
        arm = upright.translate([0, 0, 50]).scale([6, 6, 18])
        shapes["arm"] = _box(arm, 0.35)
        return shapes
    for finger in range(4):
        side = 1 if finger % 2 else -1
        place = upright.translate([side * 13.0, 9.0 - 6.0 * finger, 24.0 + 4.0 * finger])
        shapes[f"finger{finger}"] = _ball(place.rotate([0, 0, 1], 25 * side).scale([9, 17, 9]))
    palm = upright.translate([0, -24, 46]).scale([24, 30, 20])
    shapes["palm"] = _ball(palm)
    return shapes


def _box(place: Any, tone: float) -> dict[str, Any]:
    return {"type": "cube", "to_world": place, "bsdf": _plastic((tone, tone, tone * 1.1), 0.25)}


def _ball(place: Any) -> dict[str, Any]:
    return {"type": "sphere", "to_world": place, "bsdf": _plastic(_SKIN, 0.4)}


def _plastic(colour: tuple[float, float, float], alpha: float) -> dict[str, Any]:
    reflectance = {"type": "rgb", "value": list(colour)}
    return {"type": "roughplastic", "diffuse_reflectance": reflectance, "alpha": alpha}
