"""What tests of encoders share."""

import numpy as np
import pytest
from PIL import Image

from omnivat.encoders.clip import PUBLISHED


@pytest.fixture
def nothing_outside(monkeypatch, tmp_path):
    """No hub, no checkpoints of the person who runs the tests."""
    monkeypatch.setattr("omnivat.encoders.hub.fetch", lambda *_, **__: "There is no hub here.")
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    for name in ("CLIP", *(name.upper().replace("-", "_") for name in PUBLISHED)):
        monkeypatch.delenv(f"OMNIVAT_{name}", raising=False)


@pytest.fixture
def picture():
    pixels = np.random.default_rng(0).integers(0, 256, (70, 90, 3), dtype=np.uint8)
    return Image.fromarray(pixels)
