"""The photometric model: lamps light the slopes that face them, markers move, noise is seeded."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from omnivat.simulate import tactile
from omnivat.simulate.contact import Press, coloured, displacements, plane
from omnivat.simulate.sensors import GELS, Lamp, Markers
from omnivat.simulate.shapes import Spot
from omnivat.simulate.shapes.solid import block
from omnivat.simulate.surfaces import surface
from omnivat.simulate.tactile import at_rest, lit, marker_shade, touch, untouched, used
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


def test_a_flat_gel_is_unchanged_by_its_lamps():
    np.testing.assert_allclose(lit(np.full((32, 32), 0.3), GELS["GelSight"]), 0.0, atol=1e-12)


@pytest.mark.parametrize("name", GELS)
def test_every_sensor_gives_an_image_that_its_press_has_changed(name):
    sensor = GELS[name]
    image = touch(slab("plastic", 2), PRESS, sensor, size=64, seed=1)

    assert image.shape == (64, 64, 3)
    assert image.min() >= 0.0
    assert image.max() <= 1.0
    assert np.abs(image - untouched(sensor, size=64)).mean() > 0.01


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


def test_gels_of_one_sensor_differ_and_some_have_no_markers():
    gels = [used(GELS["DuraGel"], np.random.default_rng(seed)) for seed in range(40)]
    plain = sum(gel.markers is None for gel in gels)

    assert 8 < plain < 32
    assert len({gel.base for gel in gels}) == 40
    assert used(GELS["DIGIT"], np.random.default_rng(0)).markers is None
    assert all(used(GELS["GelSight"], np.random.default_rng(s)).markers for s in range(9))


def test_sensors_differ_more_than_presses_of_one_sensor():
    thing = slab("steel", 4)
    tints = {n: touch(thing, PRESS, s, size=48, seed=0).mean((0, 1)) for n, s in GELS.items()}
    deeper = replace(PRESS, depth=1.0)
    for name, sensor in GELS.items():
        moved = touch(thing, deeper, sensor, size=48, seed=0).mean((0, 1))
        own = np.linalg.norm(moved - tints[name])
        others = [np.linalg.norm(tints[name] - tints[o]) for o in GELS if o != name]
        assert own < min(others), name


def test_markers_lie_on_their_lattice_until_shear_drags_them():
    even = Markers(pitch=2.0, radius=0.3, uneven=0.0, darkness=1.0)
    still = marker_shade(np.zeros((80, 80)), even, 16.0, (0.0, 0.0))
    dragged = marker_shade(np.full((80, 80), 1.0), even, 16.0, (0.4, 0.0))

    np.testing.assert_allclose(dragged[:, 2:], still[:, :-2], atol=1e-9)  # 0.4 mm is two pixels
    assert still.max() > 0.9


def test_tac3d_reads_twenty_by_twenty_vectors_and_grey_means_nothing_moved():
    felt = displacements(slab("plastic", 2), PRESS, seed=0)

    assert felt.shape == (20, 20, 3)
    assert felt[..., 2].max() > 0.2  # mm into the sensor
    np.testing.assert_allclose(coloured(np.zeros((20, 20, 3)), size=40), 0.5, atol=0.01)
