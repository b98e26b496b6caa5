"""One small source for the tests of training, heads that learn it, and what they get right."""

import pytest

from omnivat.encoders.lang.bank import load_bank
from omnivat.head.predict_set import predicted_probabilities
from omnivat.training import TrainSettings, train
from tests.builders import head_settings


@pytest.fixture(scope="module")
def source(make_embeddings):
    return make_embeddings(domains=("TAG-sim",), per_class=16)


def learned(source, *, head=None, seed=0, **settings):
    """Train on a source with text; `head` and the rest are settings."""
    training = TrainSettings(**settings)
    return train(source, head_settings(**head or {}), training, bank=load_bank(), seed=seed)


def accuracy(model, pairs, **options):
    shares = predicted_probabilities(model, pairs, **options)["fused"]
    return float((shares.argmax(-1).numpy() == pairs.label).mean())
