"""A set that a profile mends."""

import numpy as np
import pytest

from omnivat.training import TrainSettings
from omnivat.training.from_pairs import plan_training, trained_head


@pytest.fixture(scope="package")
def shifted(make_embeddings):
    """A set whose second domain is offset: a profile finds the offset."""
    embeddings = make_embeddings(per_class=24, split=True)
    offset = 12 * np.random.default_rng(5).normal(size=embeddings.width).astype(np.float32)
    for rows in (embeddings.vis, embeddings.tac):
        rows[embeddings.domain == 1] += offset
    return embeddings


@pytest.fixture(scope="package")
def head(shifted):
    """A small head of the first of two domains that differ by an offset."""
    training = TrainSettings(epochs=15, lang=False)
    plan = plan_training(shifted, "TAG-sim", head={"width": 16}, training=training)
    return trained_head(plan, calibrate=False)
