"""VIS: the contact is in view, flat surfaces, the textures and the camera behave."""

import numpy as np
import pytest

from omnivat.kit.errors import MissingPackageError
from simulator import drawing, renderer, vision
from simulator.contact import Press
from simulator.domains import SIMULATED
from simulator.photograph import framed
from simulator.plan import planned
from simulator.scenes import SCENES
from simulator.things import thing


def thing_of(domain, material="wood", index=1):
    return thing(planned(SIMULATED[domain], material, pairs=60)[index], seed=0)


def framing_of(domain, made, seed=3):
    return framed(SCENES[domain], made, outdoors=False, seed=seed)


@pytest.mark.parametrize("domain", SCENES)
def test_the_contact_lies_in_the_picture_and_faces_the_camera(domain):
    for index in range(4):
        made = thing_of(domain, "steel", index)
        framing = framing_of(domain, made, seed=index)
        ahead = framing.target - framing.eye
        sight = made.spot.point - framing.eye
        cos = sight @ ahead / np.linalg.norm(sight) / np.linalg.norm(ahead)

        assert np.arccos(min(cos, 1.0)) < 0.75 * framing.lens
        assert -sight @ made.spot.normal > 0
        assert framing.eye[2] > 0


def gone(name, **said):
    raise MissingPackageError(f"{name} is needed for {said['purpose']}.")


def test_without_mitsuba_a_render_says_what_is_missing(monkeypatch):
    renderer.mitsuba.cache_clear()
    monkeypatch.setattr(renderer, "need", gone)
    made = thing_of("TAG")
    with pytest.raises(MissingPackageError, match="mitsuba is needed for rendering VIS"):
        vision.rendered(made, framing_of("TAG", made), size=32)


def test_without_taxim_a_calibrated_touch_says_what_is_missing(monkeypatch):
    press = Press(turn=0.0, lean=(0.0, 0.0), depth=0.5, shear=(0.0, 0.0))
    drawing._simulator.cache_clear()
    monkeypatch.setattr(drawing, "need", gone)
    with pytest.raises(MissingPackageError, match="taxim is needed for tactile images"):
        drawing.calibrated(thing_of("OF 2.0 A"), press, "CALIB_GELSIGHT", size=32)
