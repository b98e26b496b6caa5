"""Double-double arithmetic: a value is `high + low`, about 32 digits.

It has only the sums and products that the residual of an eigenvector needs.
Source: Dekker 1971 (product), Knuth 1969 (sum).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

Array = Float64[np.ndarray, "..."]

_SPLITTER = 134217729.0  # 2**27 + 1 splits a float64 into two halves of 26 bits


class Pair(NamedTuple):
    """An array with about 32 digits: `high` plus a much smaller `low`."""

    high: Array
    low: Array

    def part(self, index: slice) -> Pair:
        """Return the same slice of both arrays."""
        return Pair(self.high[index], self.low[index])


SQRT2 = Pair(np.array(1.4142135623730951), np.array(-9.667293313452913e-17))


def exact_sum(a: Array, b: Array) -> Pair:
    """Return a + b and its rounding error, exactly."""
    total = a + b
    seen = total - a
    return Pair(total, (a - (total - seen)) + (b - seen))


def halves(a: Array) -> Pair:
    """Split a into two numbers of 26 bits; their products are exact in float64."""
    scaled = _SPLITTER * a
    high = scaled - (scaled - a)
    return Pair(high, a - high)


def exact_product(a: Array, b: Array) -> Pair:
    """Return a * b and its rounding error, exactly; a and b broadcast."""
    product = a * b
    a_high, a_low = halves(a)
    b_high, b_low = halves(b)
    error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return Pair(product, error)


def add(a: Pair, b: Pair) -> Pair:
    """Return a + b; the low parts are added in float64."""
    total = exact_sum(a.high, b.high)
    return Pair(total.high, total.low + (a.low + b.low))


def multiply(a: Pair, b: Pair) -> Pair:
    """Return a * b; the product of the low parts is below 32 digits and is dropped."""
    product = exact_product(a.high, b.high)
    return Pair(product.high, product.low + (a.high * b.low + a.low * b.high))


def settle(a: Pair) -> Pair:
    """Return the same value with `low` no larger than the last digit of `high`."""
    return exact_sum(a.high, a.low)


def divide_by(a: Pair, number: float) -> Pair:
    """Return a / number for a number that float64 holds exactly."""
    quotient = a.high / number
    back = exact_product(quotient, np.array(number))
    return Pair(quotient, ((a.high - back.high) - back.low + a.low) / number)


def excess_norm(x: Float64[np.ndarray, "n m"]) -> Float64[np.ndarray, " m"]:
    """Return |x| - 1 for every nearly normalised column of x, to about 32 digits."""
    total = x * x
    high, low = halves(x)
    error = ((high * high - total) + 2.0 * high * low + low * low).sum(0)
    while total.shape[0] > 1:  # add the upper half of the rows to the lower half
        half = total.shape[0] // 2
        folded = exact_sum(total[:half], total[half : 2 * half])
        error = error + folded.low.sum(0)
        total = np.concatenate([folded.high, total[2 * half :]])
    return np.asarray(((total[0] - 1.0) + error) * 0.5)
