"""Axes of tensors are checked by letters, and rows become of length one whatever their size."""

import pytest
import torch

from omnivat.kit.errors import ShapeError
from omnivat.kit.shapes import require_shapes, unit


def test_a_letter_has_one_size_and_an_error_names_what_came_before():
    vis, tac = torch.zeros(4, 512), torch.zeros(4, 256)
    assert require_shapes(vis=(vis, "B D"), tac=(tac, "B E")) == {"B": 4, "D": 512, "E": 256}
    with pytest.raises(ShapeError, match=r"tac has shape \(4, 256\), expected \(B, D\) with B=4"):
        require_shapes(vis=(vis, "B D"), tac=(tac, "B D"))
    with pytest.raises(ShapeError, match=r"vis has shape \(4, 512\), expected \(D\)\.$"):
        require_shapes(vis=(vis, "D"))


@pytest.mark.parametrize(("size", "error"), [(1e-40, 1e-3), (1e-30, 1e-6), (1, 1e-6), (5e37, 1e-6)])
def test_rows_of_every_size_are_scaled_to_one_and_zero_stays_zero(size, error):
    rows, wanted = torch.tensor([[3.0, -4.0], [0.0, 0.0]]), torch.tensor([[0.6, -0.8], [0.0, 0.0]])
    torch.testing.assert_close(unit(rows * size), wanted, atol=error, rtol=0)


def test_unit_rows_agree_with_finite_differences_and_zero_has_no_gradient():
    rows = torch.randn(5, 4, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(unit, rows)
    zero = torch.zeros(1, 4, requires_grad=True)
    unit(zero).sum().backward()
    assert not zero.grad.any()
