"""The matrix S that commutes with the DFT, split by parity into two tridiagonal blocks.

S has 2cos(2πn/N) on its diagonal and ones next to it, cyclically. S maps even vectors to even
vectors and odd to odd. In the bases (e_j ± e_{N-j})/√2, both blocks are tridiagonal.
Source: Candan, Kutay, Ozaktas, "The discrete fractional Fourier transform", 2000.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from omnivat.fractional.double_double import (
    SQRT2,
    Array,
    Pair,
    add,
    divide_by,
    exact_product,
    exact_sum,
    multiply,
    settle,
)


@dataclass(frozen=True)
class Tridiagonal:
    """A symmetric tridiagonal matrix of size n with ones next to its diagonal.

    diagonal (n), in double-double; root_first, root_last: replace the first, the last one by √2.
    """

    diagonal: Pair
    root_first: bool = False
    root_last: bool = False

    def __len__(self) -> int:
        return len(self.diagonal.high)

    @property
    def beside(self) -> Array:
        """The n - 1 entries next to the diagonal, rounded to float64."""
        values = np.ones(len(self) - 1)
        values[:1] = SQRT2.high if self.root_first else values[:1]
        values[-1:] = SQRT2.high if self.root_last else values[-1:]
        return values

    def leading(self, size: int) -> Tridiagonal:
        """Return the block of the first `size` < n rows and columns."""
        return Tridiagonal(self.diagonal.part(slice(size)), self.root_first)

    def times(self, x: Float64[np.ndarray, "n m"]) -> Pair:
        """Return this matrix times x, to about 32 digits."""
        y = exact_product(self.diagonal.high[:, None], x)
        low = y.low + self.diagonal.low[:, None] * x
        high = y.high
        for rows, other in ((slice(None, -1), x[1:]), (slice(1, None), x[:-1])):
            high[rows], error = exact_sum(high[rows], other)
            low[rows] += error
        y = Pair(high, low)
        if self.root_first:
            _exchange(y, x, 0, 1)
        if self.root_last:
            _exchange(y, x, -1, -2)
        return y


def _exchange(y: Pair, x: Array, row: int, other: int) -> None:
    """Add (√2 - 1) times each of two rows of x to the other row of y, in place."""
    for to, source in ((row, other), (other, row)):
        root = multiply(Pair(x[source], 0 * x[source]), SQRT2)
        more = add(root, Pair(-x[source], 0 * x[source]))
        y.high[to], y.low[to] = add(Pair(y.high[to], y.low[to]), more)


def _taylor(square: Pair, first: int) -> Pair:
    """Return 1 - s/(f·(f+1)) · (1 - s/((f+2)·(f+3)) · …), s = x² ≤ (π/4)²: cos x for f = 1.

    The first four terms are in double-double; float64 is enough for the rest.
    """
    tail = np.ones_like(square.high)
    for n in range(first + 24, first + 6, -2):
        tail = 1.0 - square.high / float(n * (n + 1)) * tail
    total = Pair(tail, 0 * tail)
    unit = Pair(np.ones_like(tail), 0 * tail)
    for n in range(first + 6, first - 2, -2):
        total = add(unit, divide_by(multiply(square, total), -float(n * (n + 1))))
    return settle(total)


def doubled_cosines(size: int) -> Pair:
    """Return 2cos(2πj/N), j = 0 … N//2, in double-double; integers select the octant."""
    angle = 2 * np.arange(size // 2 + 1)  # in units of π/N
    second = 2 * angle > size
    angle = np.where(second, size - angle, angle)  # cos(π - t) = -cos t
    steep = 4 * angle > size
    eighth = np.where(steep, size - 2 * angle, 2 * angle)  # cos t = sin(π/2 - t); units π/2N
    half_pi = Pair(np.array(1.5707963267948966), np.array(6.123233995736766e-17))
    whole = eighth.astype(np.float64)
    x = settle(divide_by(multiply(Pair(whole, 0 * whole), half_pi), float(size)))
    square = multiply(x, x)
    cosine, sine = _taylor(square, 1), multiply(x, _taylor(square, 2))
    two = np.where(second, -2.0, 2.0)
    return Pair(
        two * np.where(steep, sine.high, cosine.high), two * np.where(steep, sine.low, cosine.low)
    )


def _shift_last(values: Pair, by: float) -> Pair:
    """Return a copy with `by` added to the last entry."""
    high, low = values.high.copy(), values.low.copy()
    last = exact_sum(high[-1:], np.array([by]))
    high[-1:], low[-1:] = last.high, low[-1:] + last.low
    return Pair(high, low)


def parity_blocks(size: int) -> tuple[Tridiagonal, Tridiagonal]:
    """Return S on even vectors, of size N//2 + 1, and on odd vectors, of size (N-1)//2; N ≠ 2."""
    cosines = doubled_cosines(size)
    if size % 2 == 0:
        odd = cosines.part(slice(1, -1))
        return Tridiagonal(cosines, root_first=True, root_last=True), Tridiagonal(odd)
    # For odd N the two middle samples are both neighbours and mirror images.
    return (
        Tridiagonal(_shift_last(cosines, 1.0), root_first=True),
        Tridiagonal(_shift_last(cosines.part(slice(1, None)), -1.0)),
    )
