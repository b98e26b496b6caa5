"""The photometric model: lamps light the slopes that face them."""

from dataclasses import replace

import numpy as np
import pytest

from omnivat.simulate.contact import plane
from omnivat.simulate.sensors import GELS, Lamp
from omnivat.simulate.tactile import lit


@pytest.mark.parametrize(
    ("azimuth", "near", "far"),
    [
        (0, (32, 44), (32, 19)),
        (90, (19, 32), (44, 32)),
        (180, (32, 19), (32, 44)),
        (270, (44, 32), (19, 32)),
    ],
    ids=["right", "top", "left", "bottom"],
)
def test_a_lamp_lights_the_flank_of_a_bump_that_faces_it(azimuth, near, far):
    lamp = Lamp(azimuth=azimuth, colour=(1.0, 0.0, 0.0))
    sensor = replace(GELS["DIGIT"], lamps=(lamp,), base=(0.0, 0.0, 0.0))
    x, y = plane(sensor.field, 64)
    change = lit(np.exp(-(x**2 + y**2) / 8), sensor)

    assert change[near][0] > 0.05 > -0.05 > change[far][0]
    assert change[near][1:] == pytest.approx(0.0)
