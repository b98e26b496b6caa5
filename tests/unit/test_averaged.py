"""Predictions averaged over orders."""

import pytest
import torch

from omnivat.averaged import averaged_probabilities
from omnivat.errors import SettingsError
from omnivat.evaluate import predicted_probabilities
from omnivat.model.head import build_head
from omnivat.model.settings import HeadSettings


@pytest.fixture(scope="module")
def pairs(make_embeddings):
    return make_embeddings(per_class=2)


@pytest.fixture(scope="module")
def model(pairs):
    settings = HeadSettings(classes=pairs.header.classes, input_width=pairs.width, width=16)
    return build_head(settings).eval()


def test_the_average_is_the_mean_of_the_predictions_at_each_order(model, pairs):
    found = averaged_probabilities(model, pairs, (0.1, 0.7))
    each = [predicted_probabilities(model, pairs, order=p) for p in (0.1, 0.7)]
    for name, shares in found.items():
        torch.testing.assert_close(shares, (each[0][name] + each[1][name]) / 2)
    torch.testing.assert_close(found["fused"].sum(1), torch.ones(len(pairs)))


def test_no_orders_are_refused(model, pairs):
    with pytest.raises(SettingsError, match="no orders to average over"):
        averaged_probabilities(model, pairs, ())
