"""Contact: a gel lies on what presses it, hangs around it, and is untouched elsewhere."""

import numpy as np

from simulator.contact import indentation
from simulator.noise import plane
from simulator.sensors import Gel


def ball(field, size, radius):
    x, y = plane(field, size)
    return np.sqrt(np.maximum(radius**2 - x**2 - y**2, 0.0)) - radius


def test_a_ball_touches_in_a_disc_of_the_radius_that_geometry_gives():
    field, size, radius, depth = 16.0, 160, 6.0, 0.5
    gel = Gel(field=field, depth=(depth, depth), skin=0.1, give=0.8, dome=0.0)
    indent = indentation(ball(field, size, radius), gel, depth)
    area = (indent > 0).sum() * (field / size) ** 2

    np.testing.assert_allclose(area, np.pi * (2 * radius * depth - depth**2), rtol=0.07)
