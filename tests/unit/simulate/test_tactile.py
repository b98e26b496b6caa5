"""The photometric model: lamps light the slopes that face them, markers move, noise is seeded."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from omnivat.simulate import tactile
from omnivat.simulate.contact import Press, plane
from omnivat.simulate.sensors import GELS, Lamp, Markers
from omnivat.simulate.shapes import Spot
from omnivat.simulate.shapes.solid import block
from omnivat.simulate.surfaces import surface
from omnivat.simulate.tactile import at_rest, lit, marker_shade, touch
from omnivat.simulate.things import Thing

PRESS = Press(turn=0.4, lean=(0.0, 0.0), depth=0.5, shear=(0.05, 0.0))
RED_FROM_THE_RIGHT = replace(
    GELS["DIGIT"], lamps=(Lamp(azimuth=0, colour=(1.0, 0.0, 0.0)),), base=(0.0, 0.0, 0.0)
)


def slab(material, number):
    """Return a flat thing of this surface, touched in the middle of its top."""
    own = surface(material, number, seed=0)
    spot = Spot(
        point=np.array([0.0, 0.0, 10.0]), normal=np.array([0.0, 0.0, 1.0]),
        tangent=np.array([1.0, 0.0, 0.0]), uv=np.array([1.0, 2.0]),
    )  # fmt: skip
    solid = block((60.0, 60.0, 20.0), bevel=1.0)
    return Thing(solid=solid, sight=own, touch=own, spot=spot)


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
    sensor = replace(RED_FROM_THE_RIGHT, lamps=(Lamp(azimuth=azimuth, colour=(1.0, 0.0, 0.0)),))
    x, y = plane(sensor.field, 64)
    change = lit(np.exp(-(x**2 + y**2) / 8), sensor)

    assert change[near][0] > 0.05 > -0.05 > change[far][0]
    assert change[near][1:] == pytest.approx(0.0)


@pytest.mark.parametrize("name", GELS)
def test_a_press_that_touches_nothing_with_a_new_gel_is_the_rest_picture_but_for_noise(
    name, monkeypatch
):
    monkeypatch.setattr(tactile, "indentation", lambda h, **_: np.zeros_like(h))
    monkeypatch.setattr(tactile, "used", lambda sensor, _: sensor)
    monkeypatch.setattr(tactile, "blotted", lambda image, *_, **__: image)
    still = replace(PRESS, shear=(0.0, 0.0))
    image = touch(slab("plastic", 2), still, GELS[name], size=64, seed=1)
    rest = at_rest(GELS[name], size=64)

    scale = (image * rest).sum() / (rest * rest).sum()  # the exposure of one picture
    assert 0.85 < scale < 1.15
    smooth = gaussian_filter(image - scale * rest, (3, 3, 0))  # noise averages out
    assert np.abs(smooth).mean() < 0.004


def test_markers_lie_on_their_lattice_until_shear_drags_them():
    even = Markers(pitch=2.0, radius=0.3, uneven=0.0, darkness=1.0)
    still = marker_shade(np.zeros((80, 80)), even, 16.0, (0.0, 0.0))
    dragged = marker_shade(np.full((80, 80), 1.0), even, 16.0, (0.4, 0.0))

    np.testing.assert_allclose(dragged[:, 2:], still[:, :-2], atol=1e-9)  # 0.4 mm is two pixels
    assert still.max() > 0.9
