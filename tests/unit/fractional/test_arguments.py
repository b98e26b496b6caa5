"""Invalid arguments and their error sentences."""

import math

import numpy as np
import pytest
import torch

from omnivat.fractional import basis, coefficients, dfrft, synthesise
from omnivat.kit.errors import SettingsError, ShapeError

X = torch.ones(5, 12)


@pytest.mark.parametrize(
    "order", [math.nan, math.inf, -math.inf, torch.tensor([0.1, math.nan, 0.2, 0.3, 0.4])]
)
def test_an_order_that_is_no_number_is_refused(order):
    for call in (lambda: dfrft(X, order), lambda: synthesise(coefficients(X), order)):
        with pytest.raises(SettingsError, match="holds NaN or infinity, expected finite quarter"):
            call()


@pytest.mark.parametrize("order", [1j, "half", None, torch.tensor(1j)])
def test_an_order_that_is_not_real_is_refused(order):
    with pytest.raises(SettingsError, match="expected (a finite real number|real quarter turns)"):
        dfrft(X, order)


@pytest.mark.parametrize("order", [1, 0.3])
def test_arrays_and_lists_of_numbers_are_transformed(order):
    for array in (np.ones((5, 12))[:, ::-1], [[1] * 12] * 5):
        whole = torch.from_numpy(np.array(array, float)).to(torch.get_default_dtype())
        assert torch.allclose(dfrft(array, order).to(torch.complex64), dfrft(whole, order))
    assert dfrft(np.ones(3), order).dtype == torch.complex128


@pytest.mark.parametrize(("x", "dim"), [(X, 2), (X, -3), (torch.tensor(1.0), 0)])
def test_an_axis_that_is_not_there_is_refused(x, dim):
    for order in (0.3, 1):
        with pytest.raises(ShapeError, match="choose an existing axis"):
            dfrft(x, order, dim)


def test_an_axis_without_samples_is_refused():
    with pytest.raises(ShapeError, match="one sample or more along axis"):
        dfrft(torch.zeros(3, 0), 0.3)


def test_orders_that_do_not_fit_say_how_to_write_many():
    with pytest.raises(ShapeError, match=r"shape \(3,\).*\(5,\): use order\[:, None\]"):
        dfrft(X, torch.zeros(3))


@pytest.mark.parametrize(
    ("size", "dtype"),
    [(0, torch.float64), (1.5, torch.float64), ("x", torch.float64), (8, torch.float16)],
)
def test_a_basis_that_cannot_be_is_refused(size, dtype):
    with pytest.raises(ShapeError, match=f"size {size!r} in {dtype} was requested"):
        basis(size, dtype=dtype)
