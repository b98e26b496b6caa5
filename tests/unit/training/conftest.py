"""One small source and head for the tests of training."""

import pytest
import torch

from omnivat.head.settings import HeadSettings

CLASSES = ("wood", "steel", "plastic", "ceramic", "glass")


@pytest.fixture(scope="module")
def source(make_embeddings):
    return make_embeddings(domains=("TAG-sim",), per_class=16)


def equal_weights(first, second):
    one, two = first.state_dict(), second.state_dict()
    return all(torch.equal(one[name], two[name]) for name in one)


def head(**changes):
    """Return settings of a light head for the source."""
    values = {"classes": CLASSES, "input_width": 24, "width": 32, "lang_width": 384}
    return HeadSettings(**(values | changes))
