"""What else is in the picture: the sensor on the object, and the hand or clamp that holds it."""

from typing import Any

import numpy as np

from omnivat.simulate.framing import Framing
from omnivat.simulate.scenes import Colour

_HOUSING = 9.0  # mm, radius of a sensor
_SKIN = (0.52, 0.30, 0.21)
_BLACK = (0.025, 0.025, 0.03)
_GREY = (0.16, 0.16, 0.17)


def props(mi: Any, framing: Framing) -> dict[str, Any]:
    """Return Mitsuba shapes for what stands on the contact, or nothing."""
    rng = np.random.default_rng(framing.seed + 1)
    if not framing.held:
        return {}
    yaw, lean = float(rng.uniform(0, 360)), float(rng.uniform(-12, 12))
    stand = mi.ScalarTransform4f().rotate([0, 0, 1], yaw).rotate([1, 0, 0], lean)
    shapes = {"housing": _rod(mi, stand, length=26.0, radius=_HOUSING, colour=_BLACK)}
    if framing.scene.prop == "clamp":
        shapes["arm"] = _rod(mi, stand.translate([0, 0, 26]), 60.0, 5.0, _GREY)
        return shapes
    sleeve = stand.translate([0, 6, 30]).rotate([1, 0, 0], -58)
    shapes["wrist"] = _rod(mi, sleeve, length=30.0, radius=13.0, colour=_SKIN)
    shapes["sleeve"] = _rod(mi, sleeve.translate([0, 0, 22]), 150.0, 21.0, _BLACK)
    for finger, (x, y, turn) in enumerate(((9, 4, 20), (-9, 4, -20), (4, -9, 75))):
        place = stand.translate([x, y, 23]).rotate([0, 0, 1], turn).scale([5.5, 13, 6])
        shapes[f"finger{finger}"] = {"type": "sphere", "to_world": place, "bsdf": _plastic(_SKIN)}
    return shapes


def _rod(mi: Any, place: Any, length: float, radius: float, colour: Colour) -> dict[str, Any]:
    """Return a closed cylinder that stands on `place`."""
    return {
        "type": "cylinder", "to_world": place, "p0": [0, 0, 0.2], "p1": [0, 0, length],
        "radius": radius, "bsdf": {"type": "twosided", "bsdf": _plastic(colour)},
    }  # fmt: skip


def _plastic(colour: Colour) -> dict[str, Any]:
    reflectance = {"type": "rgb", "value": list(colour)}
    return {"type": "roughplastic", "diffuse_reflectance": reflectance, "alpha": 0.3}
