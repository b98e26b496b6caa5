"""Coefficients are indexed like their batch, and whole orders of any size are exact."""

import numpy as np
import pytest
import torch

from omnivat.fractional import coefficients, dfrft, synthesise
from omnivat.kit.errors import ShapeError

MASK = torch.tensor([True, False, True])
TABLE = torch.tensor([[3, 1], [0, 0]])


@pytest.mark.parametrize(
    "index",
    [0, (0, 1), (..., 1), (slice(None), slice(1, 3)), (None, 0), MASK, (..., TABLE)],
    ids=str,
)
def test_indexed_coefficients_give_the_indexed_transform(index):
    x = torch.arange(3.0 * 4 * 5).reshape(3, 4, 5).sin()
    parts = index if isinstance(index, tuple) else (index,)
    parts = parts if parts[0] is ... else (*parts, ...)
    wanted = dfrft(x, 0.3)[(*parts, slice(None))]
    torch.testing.assert_close(synthesise(coefficients(x)[index], 0.3), wanted)


def test_coefficients_of_an_inner_axis_are_not_indexed():
    with pytest.raises(ShapeError, match="axis -2 cannot be indexed: index x before"):
        coefficients(torch.zeros(3, 8, 5), dim=1)[0]


@pytest.mark.parametrize("order", [0, 1, 2, 3, -1])
def test_results_at_whole_orders_turn_into_numpy_arrays(order):
    assert dfrft(torch.ones(2, 8), order).numpy().dtype == np.complex64


@pytest.mark.parametrize("order", [2**53 + 1, 2**53 + 3, 10**30 + 1, -(2**60) - 1])
def test_both_ways_reduce_a_huge_whole_order_alike(order):
    x = torch.arange(8.0, dtype=torch.float64)
    torch.testing.assert_close(dfrft(x, order), synthesise(coefficients(x), order))
