"""VIS: the contact is in view."""

import numpy as np
import pytest

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
