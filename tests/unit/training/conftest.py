"""One small source for the tests of training, and whether two heads are the same."""

import pytest
import torch


@pytest.fixture(scope="module")
def source(make_embeddings):
    return make_embeddings(domains=("TAG-sim",), per_class=16)


def equal_weights(first, second):
    one, two = first.state_dict(), second.state_dict()
    return all(torch.equal(one[name], two[name]) for name in one)
