"""Coefficients are indexed like their batch, for any position of the transformed axis."""

import numpy as np
import pytest
import torch

from omnivat.fractional import coefficients, dfrft, synthesise
from omnivat.kit.errors import ShapeError

MASK = torch.tensor([True, False, True])
FLAT = torch.ones(4, 4, dtype=torch.bool).tril()
INDICES = [
    0,
    (slice(None), 0),
    (slice(None), slice(1, 3)),
    (0, slice(None), 2),
    (0, 1),
    (Ellipsis, 1),
    (Ellipsis, slice(None, None, 2)),
    (None, 0),
    MASK,
    [2, 0],
    (slice(None), torch.tensor([3, 1])),
    (slice(None), torch.tensor([[3, 1], [0, 0]])),
]


@pytest.mark.parametrize("dim", [0, 1, 2, 3])
@pytest.mark.parametrize("index", INDICES, ids=str)
def test_indexed_coefficients_give_the_indexed_transform(dim, index):
    x = torch.arange(3.0 * 4 * 4 * 5).reshape(3, 4, 4, 5).sin()
    x = x.movedim(-1, dim)  # the leading axes are 3, 4 and 4 whatever `dim` is
    kept = coefficients(x, dim=dim)
    wanted = dfrft(x, 0.3, dim=dim).movedim(dim, -1)
    parts = index if isinstance(index, tuple) else (index,)
    parts = parts if Ellipsis in [p for p in parts if p is Ellipsis] else (*parts, Ellipsis)
    wanted = wanted[(*parts, slice(None))]
    found = synthesise(kept[index], 0.3)
    torch.testing.assert_close(found.movedim(kept[index].dim, -1), wanted)


def test_an_axis_taken_after_the_transformed_one_leaves_that_one_last():
    kept = coefficients(torch.zeros(3, 8, 5), dim=1)
    assert synthesise(kept[:, 0], 0.3).shape == (3, 8)
    assert synthesise(kept[0], 0.3).shape == (8, 5)
    assert synthesise(kept[0, 0], 0.3).shape == (8,)


def test_several_tables_in_one_index_are_refused_where_axes_follow():
    kept = coefficients(torch.zeros(3, 8, 5), dim=1)
    with pytest.raises(ShapeError, match="index one axis after the other"):
        kept[[0, 1], [1, 2]]


@pytest.mark.parametrize("order", [0, 1, 2, 3, -1])
def test_results_at_whole_orders_turn_into_numpy_arrays(order):
    assert dfrft(torch.ones(2, 8), order).numpy().dtype == np.complex64


@pytest.mark.parametrize("order", [2**53 + 1, 2**53 + 3, 10**30 + 1, -(2**60) - 1])
def test_both_ways_reduce_a_huge_whole_order_alike(order):
    x = torch.arange(8.0, dtype=torch.float64)
    torch.testing.assert_close(dfrft(x, order), synthesise(coefficients(x), order))


def test_a_mask_over_axes_on_one_side_joins_them_and_across_both_sides_is_refused():
    x = torch.arange(3.0 * 4 * 4 * 5).reshape(3, 4, 4, 5).sin()
    before, between = coefficients(x, dim=3), coefficients(x.movedim(-1, 2), dim=2)
    wanted = dfrft(x, 0.3)[:, FLAT]
    torch.testing.assert_close(synthesise(before[:, FLAT], 0.3), wanted)
    with pytest.raises(ShapeError, match="cannot span axes on both sides"):
        between[:, FLAT]
