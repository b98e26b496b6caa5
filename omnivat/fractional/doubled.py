"""Arithmetic in pairs of float64: a value is `high + low`, about 32 digits.

Only what the residual of an eigenvector needs: sums and products whose rounding error is kept.
Source: Dekker 1971 (product), Knuth 1969 (sum).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_SPLITTER = 134217729.0  # 2**27 + 1 cuts a float64 into two halves of 26 bits


class Pair(NamedTuple):
    """An array known to about 32 digits: the sum of `high` and a much smaller `low`."""

    high: Array
    low: Array

    def part(self, index: slice) -> Pair:
        """The same slice of both arrays."""
        return Pair(self.high[index], self.low[index])


SQRT2 = Pair(np.array(1.4142135623730951), np.array(-9.667293313452913e-17))


def exact_sum(a: Array, b: Array) -> Pair:
    """a + b and its rounding error, exactly."""
    total = a + b
    seen = total - a
    return Pair(total, (a - (total - seen)) + (b - seen))


def exact_product(a: Array, b: Array) -> Pair:
    """a * b and its rounding error, exactly."""
    product = a * b
    t = _SPLITTER * a
    a_high = t - (t - a)
    a_low = a - a_high
    t = _SPLITTER * b
    b_high = t - (t - b)
    b_low = b - b_high
    error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return Pair(product, error)


def add(a: Pair, b: Pair) -> Pair:
    """a + b; the low parts are added in float64."""
    total = exact_sum(a.high, b.high)
    return Pair(total.high, total.low + (a.low + b.low))


def multiply(a: Pair, b: Pair) -> Pair:
    """a * b; the product of the low parts is below 32 digits and dropped."""
    product = exact_product(a.high, b.high)
    return Pair(product.high, product.low + (a.high * b.low + a.low * b.high))


def settle(a: Pair) -> Pair:
    """The same value with `low` no larger than the last digit of `high`."""
    return exact_sum(a.high, a.low)


def divide_by(a: Pair, number: float) -> Pair:
    """a / number for a number that float64 holds exactly."""
    quotient = a.high / number
    back = exact_product(quotient, np.full_like(quotient, number))
    return Pair(quotient, ((a.high - back.high) - back.low + a.low) / number)


def scale_rows(rows: Pair, x: Array) -> Pair:
    """rows[:, None] * x for a float64 matrix x."""
    product = exact_product(np.broadcast_to(rows.high[:, None], x.shape), x)
    return Pair(product.high, product.low + rows.low[:, None] * x)


def excess_norm(x: Array) -> Array:
    """|x| - 1 for every nearly normalised column of x, to about 32 digits."""
    square = exact_product(x, x)
    total, low = square.high, square.low.sum(0)
    while total.shape[0] > 1:  # add the upper half of the rows to the lower half
        half = total.shape[0] // 2
        folded = exact_sum(total[:half], total[half : 2 * half])
        low = low + folded.low.sum(0)
        total = np.concatenate([folded.high, total[2 * half :]])
    return np.asarray(((total[0] - 1.0) + low) * 0.5)
