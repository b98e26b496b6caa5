"""One small source and head for the tests of training."""

import pytest

from omnivat.head.settings import HeadSettings

CLASSES = ("wood", "steel", "plastic", "ceramic", "glass")


@pytest.fixture(scope="module")
def source(make_embeddings):
    return make_embeddings(domains=("TAG-sim",), per_class=16)


def head(**changes):
    """Return settings of a light head for the source."""
    values = {"classes": CLASSES, "input_width": 24, "width": 32, "lang_width": 384}
    return HeadSettings(**(values | changes))
