"""A set that a profile mends."""

import numpy as np
import pytest


@pytest.fixture(scope="module")
def shifted(make_embeddings):
    """A set whose second domain is offset: a profile finds the offset."""
    embeddings = make_embeddings(per_class=24, split=True)
    offset = 12 * np.random.default_rng(5).normal(size=embeddings.width).astype(np.float32)
    for rows in (embeddings.vis, embeddings.tac):
        rows[embeddings.domain == 1] += offset
    return embeddings
