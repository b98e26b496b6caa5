"""What tests of frames share."""

import pytest

from omnivat.maps.frames import build_frames

from .small_head import MAPS, ORDERS, head, pairs


@pytest.fixture(scope="session")
def frames():
    return build_frames(head(), pairs(), orders=ORDERS, maps=MAPS, provenance={"source": "D0"})
