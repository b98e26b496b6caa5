"""Logistic regression against another solver, and the scalings in front of it."""

import numpy as np
import pytest
import torch
from sklearn.linear_model import LogisticRegression

from omnivat.kit.logistic import scaling, solve


def problem(count, width, classes=3, seed=0):
    random = np.random.default_rng(seed)
    labels = np.arange(count) % classes
    rows = random.normal(size=(count, width)) + 1.5 * random.normal(size=(classes, width))[labels]
    return torch.from_numpy(rows), torch.from_numpy(labels)


@pytest.mark.parametrize("strength", [0.01, 100.0])
@pytest.mark.parametrize(("count", "width"), [(60, 5), (12, 30)])
def test_it_finds_the_optimum_that_another_solver_finds(count, width, strength):
    rows, labels = problem(count, width)
    weight, bias = solve(rows, labels, 3, strength)
    other = LogisticRegression(C=strength, tol=1e-10, max_iter=10_000).fit(rows, labels)
    ours = torch.softmax(rows @ weight.T + bias, -1)
    np.testing.assert_allclose(ours, other.predict_proba(rows), atol=1e-4)
    np.testing.assert_allclose(
        weight - weight.mean(0), other.coef_ - other.coef_.mean(0), atol=1e-3
    )


def test_standard_scaling_gives_unit_variance_and_leaves_a_constant_axis_at_zero():
    rows = torch.randn(50, 4, dtype=torch.float64) * torch.tensor([1.0, 5.0, 0.1, 0.0]) + 3
    rows[::2, 3] += 4e-16  # rounding is no spread
    scaled = scaling(rows, "standard")(rows)
    torch.testing.assert_close(scaled[:, :3].var(0, correction=0), torch.ones(3).double())
    assert (scaled[:, 3] == 0).all()
    for kind in ("unit", "standard"):  # rows without any spread say nothing about others
        assert not scaling(torch.zeros(3, 2), kind)(torch.ones(1, 2)).any()


def test_unit_scaling_ignores_the_length_of_a_row():
    rows = torch.randn(20, 6, dtype=torch.float64)
    scale = scaling(rows, "unit")
    torch.testing.assert_close(scale(rows), scale(7 * rows))
    assert scale(rows).square().mean().item() == pytest.approx(1)
