"""Contact: a gel lies on what presses it, hangs around it, and is untouched elsewhere."""

import numpy as np

from omnivat.simulate.contact import draped, indentation, plane


def ball(field, size, radius):
    x, y = plane(field, size)
    return np.sqrt(np.maximum(radius**2 - x**2 - y**2, 0.0)) - radius


def test_a_ball_touches_in_a_disc_of_the_radius_that_geometry_gives():
    field, size, radius, depth = 16.0, 160, 6.0, 0.5
    indent = indentation(ball(field, size, radius), field=field, depth=depth, dome=0.0)
    area = (indent > 0).sum() * (field / size) ** 2

    np.testing.assert_allclose(area, np.pi * (2 * radius * depth - depth**2), rtol=0.07)


def test_the_gel_never_goes_through_the_object_nor_lifts_where_nothing_presses():
    indent = indentation(ball(16.0, 96, 4.0), field=16.0, depth=0.6, dome=0.0)
    sheet = draped(indent, field=16.0, give=0.8, skin=1e-3)

    assert (sheet >= indent - 1e-9).all()
    assert sheet[0, 0] < 1e-3 * sheet.max()
