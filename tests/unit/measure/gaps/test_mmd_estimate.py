"""The Gaussian MMD of large sets: an estimate whose stated error holds."""

from itertools import combinations

import torch

from omnivat.measure.gaps import mmd
from omnivat.measure.gaps.mmd import mmd_rbf, mmd_rbf_estimate


def rows(count, shift, seed):
    generator = torch.Generator().manual_seed(seed)
    return torch.randn(count, 16, generator=generator) + shift


def test_the_square_of_a_mean_over_all_rows_has_no_bias_from_a_sample():
    every = rows(5, 0.0, 3).double()
    waves = torch.randn(16, 7, dtype=torch.float64, generator=torch.Generator().manual_seed(0))
    of_all = mmd._waves(every, waves, 5)[1]
    samples = [mmd._waves(every[list(some)], waves, 5)[1] for some in combinations(range(5), 3)]
    torch.testing.assert_close(torch.stack(samples).mean(0), of_all)


def test_large_sets_take_the_estimate_and_small_ones_the_exact_sum(monkeypatch):
    a, b = rows(90, 0.0, 1), rows(80, 0.6, 2)
    exact = mmd_rbf(a, b)
    monkeypatch.setattr(mmd, "MOST_ROWS", 100)
    assert torch.equal(mmd_rbf(a, b), mmd_rbf_estimate(a, b).value)
    assert not torch.equal(mmd_rbf(a, b), exact)


def test_the_estimate_takes_the_width_of_all_rows_of_both_sets_whatever_their_sizes():
    """Weighted by the sets' sizes: the larger and more spread one counts more."""
    a, b = rows(30, 0.0, 1), rows(900, 0.0, 2) + torch.linspace(0, 6, 16)
    found = mmd_rbf_estimate(a, b)
    assert abs(found.value - mmd_rbf(a, b)) < 2 * found.error < 0.05 * found.value
