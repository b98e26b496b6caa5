"""A set that a profile mends."""

import pytest

from omnivat.training import TrainSettings, plan_training, trained_head
from tests.builders import move_domains


@pytest.fixture(scope="package")
def shifted(make_embeddings):
    """A set whose second domain is offset: a profile finds the offset."""
    return move_domains(make_embeddings(per_class=24, split=True), 12, seed=5)


@pytest.fixture(scope="package")
def head(shifted):
    """A small head of the first of two domains that differ by an offset."""
    training = TrainSettings(epochs=15, lang=False)
    plan = plan_training(shifted, "TAG-sim", head={"width": 16}, training=training)
    return trained_head(plan, calibrate=False)
