"""Height maps of solids: exact on known shapes, the same from every side."""

import numpy as np

from simulator.noise import plane
from simulator.shapes import Spot
from simulator.shapes.solid import turned
from simulator.shapes.spots import contact_height

RADIUS = 30.0


def cylinder_spot():
    return Spot(
        point=np.array([RADIUS, 0.0, 30.0]), normal=np.array([1.0, 0.0, 0.0]),
        tangent=np.array([0.0, 1.0, 0.0]), uv=np.zeros(2),
    )  # fmt: skip


def cylinder():
    return turned([(0, 0, 0), (RADIUS, 0, 0.5), (RADIUS, 60, 0.5), (0, 60, 0)])


def test_a_cylinder_has_no_facets():
    """Its triangles alone are 7 micrometres off, in flat strips that a gel would show."""
    x, _ = plane(16.0, 96)
    height = contact_height(cylinder(), cylinder_spot(), field=16.0, size=96)

    np.testing.assert_allclose(height, np.sqrt(RADIUS**2 - x**2) - RADIUS, atol=1e-3)
