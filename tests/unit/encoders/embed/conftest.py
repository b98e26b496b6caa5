"""What tests of embedding share."""

import pytest

from omnivat.encoders import ENCODERS

from .small_pairs import load_mean


@pytest.fixture
def mean_encoder(monkeypatch):
    monkeypatch.setattr("omnivat.encoders.efficientnet.load_lite0", load_mean)
    assert ENCODERS["efficientnet-lite0"].endswith("load_lite0")
