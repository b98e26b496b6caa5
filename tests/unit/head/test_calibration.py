"""Temperatures and scores of confidence, against figures worked out by hand."""

import pytest
import torch

from omnivat.head.calibration import fit_calibration, fit_temperature
from omnivat.kit.errors import DataError


def sampled(logits, seed=0):
    """Return labels drawn from the logits' own softmax: their best temperature is one."""
    random = torch.Generator().manual_seed(seed)
    return torch.multinomial(logits.softmax(-1), 1, generator=random)[:, 0]


@pytest.fixture(scope="module")
def honest():
    logits = 2 * torch.randn(8_000, 5, generator=torch.Generator().manual_seed(1)).double()
    return logits, sampled(logits)


@pytest.mark.parametrize("factor", [0.25, 4.0])
def test_the_temperature_undoes_a_factor_of_honest_logits(honest, factor):
    logits, labels = honest
    assert fit_temperature(factor * logits, labels) == pytest.approx(factor, rel=0.03)


def test_logits_that_say_nothing_get_the_highest_temperature():
    random = torch.Generator().manual_seed(2)
    logits = torch.randn(4000, 5, generator=random)
    assert 15 < fit_temperature(logits, torch.randint(5, (4000,), generator=random)) <= 20


def test_a_temperature_without_pairs_is_refused():
    with pytest.raises(DataError, match="held-out pairs; there are none"):
        fit_temperature(torch.zeros(0, 5), torch.zeros(0, dtype=torch.long))


def test_a_head_of_one_modality_is_calibrated_for_that_one(honest):
    logits, labels = honest
    found = fit_calibration({"vis": 3 * logits}, labels)
    assert found["vis"] == pytest.approx(3, rel=0.03)
    assert found["fused"] == found["vis"]
    assert found["tac"] == 1
