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


@pytest.mark.parametrize("size", [1e-40, 1e-30, 1.0, 5e37])
def test_rows_of_every_size_are_scaled_to_one_and_zero_stays_zero(size):
    rows = torch.tensor([[3.0, -4.0], [0.0, 0.0]]) * size
    torch.testing.assert_close(
        unit(rows), torch.tensor([[0.6, -0.8], [0.0, 0.0]]), atol=1e-3, rtol=0
    )
    if size == 1.0:
        rows.requires_grad_(True)
        unit(rows).sum().backward()
        assert rows.grad[0].abs().sum() > 0 and not rows.grad[1].any()
