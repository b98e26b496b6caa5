"""The matrix S that commutes with the DFT, cut by parity into two tridiagonal blocks.

S has 2cos(2πn/N) on its diagonal and ones beside it, cyclically. Even vectors and odd vectors are
each mapped to themselves, and in the bases (e_j ± e_{N-j})/√2 both blocks are tridiagonal.
Source: Candan, Kutay, Ozaktas, "The discrete fractional Fourier transform", 2000.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omnivat.fractional.doubled import (
    SQRT2,
    Array,
    Pair,
    add,
    divide_by,
    exact_sum,
    multiply,
    scale_rows,
    settle,
)


@dataclass(frozen=True)
class Tridiagonal:
    """A symmetric tridiagonal matrix of size n: `diagonal` (n), `beside` (n-1), both doubled."""

    diagonal: Pair
    beside: Pair

    def __len__(self) -> int:
        return len(self.diagonal.high)

    def leading(self, size: int) -> Tridiagonal:
        """The block of the first `size` rows and columns."""
        return Tridiagonal(self.diagonal.part(slice(size)), self.beside.part(slice(size - 1)))

    def times(self, x: Array) -> Pair:
        """This matrix times x (n, m), to about 32 digits."""
        y = scale_rows(self.diagonal, x)
        if len(self) > 1:
            for rows, other in ((slice(None, -1), x[1:]), (slice(1, None), x[:-1])):
                part = add(y.part(rows), scale_rows(self.beside, other))
                y.high[rows], y.low[rows] = part
        return y


@dataclass(frozen=True)
class ParityBlocks:
    """S on even vectors (size N//2 + 1) and on odd vectors (size (N-1)//2)."""

    even: Tridiagonal
    odd: Tridiagonal


def _cosine(x: Pair) -> Pair:
    """cos x for 0 ≤ x ≤ π/4: three terms doubled, the rest is too small to need it."""
    square = multiply(x, x)
    s = square.high
    rest = s**3 * _series(s, range(8, 26, 2), -1.0 / 720)
    terms = add(Pair(np.ones_like(s), np.zeros_like(s)), divide_by(square, -2.0))
    return settle(add(add(terms, divide_by(multiply(square, square), 24.0)), Pair(rest, 0 * rest)))


def _sine(x: Pair) -> Pair:
    """sin x for 0 ≤ x ≤ π/4: three terms doubled, the rest is too small to need it."""
    square = multiply(x, x)
    s = square.high
    rest = s**3 * x.high * _series(s, range(9, 27, 2), -1.0 / 5040)
    cube = multiply(x, square)
    terms = add(add(x, divide_by(cube, -6.0)), divide_by(multiply(cube, square), 120.0))
    return settle(add(terms, Pair(rest, 0 * rest)))


def _series(square: Array, last: range, first: float) -> Array:
    """first · (1 - s/(7·8) · (1 - s/(9·10) · …)), the tail of a Taylor series in s = x²."""
    total = np.ones_like(square)
    for n in reversed(last):
        total = 1.0 - square / float(n * (n - 1)) * total
    return np.asarray(first * total)


def doubled_cosines(size: int) -> Pair:
    """2cos(2πj/N) for j = 0 … N//2, doubled; the octant is found in integers."""
    angle = 2 * np.arange(size // 2 + 1)  # in units of π/N
    second = 2 * angle > size
    angle = np.where(second, size - angle, angle)  # cos(π - t) = -cos t
    steep = 4 * angle > size
    eighth = np.where(steep, size - 2 * angle, 2 * angle)  # cos t = sin(π/2 - t); units π/2N
    half_pi = Pair(np.array(1.5707963267948966), np.array(6.123233995736766e-17))
    whole = eighth.astype(np.float64)
    x = settle(divide_by(multiply(Pair(whole, 0 * whole), half_pi), float(size)))
    cosine, sine = _cosine(x), _sine(x)
    two = np.where(second, -2.0, 2.0)
    return Pair(
        two * np.where(steep, sine.high, cosine.high), two * np.where(steep, sine.low, cosine.low)
    )


def _ones(size: int) -> Pair:
    return Pair(np.ones(max(size, 0)), np.zeros(max(size, 0)))


def _shift_last(values: Pair, by: float) -> Pair:
    """A copy with `by` added to the last entry."""
    high, low = values.high.copy(), values.low.copy()
    last = exact_sum(high[-1:], np.array([by]))
    high[-1:], low[-1:] = last.high, low[-1:] + last.low
    return Pair(high, low)


def parity_blocks(size: int) -> ParityBlocks:
    """Both blocks of S for length N ≥ 3."""
    cosines = doubled_cosines(size)
    half = (size - 1) // 2
    odd = cosines.part(slice(1, half + 1))
    beside = _ones(size // 2)
    beside.high[0], beside.low[0] = SQRT2.high, SQRT2.low
    if size % 2 == 0:
        beside.high[-1], beside.low[-1] = SQRT2.high, SQRT2.low
        return ParityBlocks(Tridiagonal(cosines, beside), Tridiagonal(odd, _ones(half - 1)))
    # For odd N the middle samples are each other's neighbour and mirror image at once.
    return ParityBlocks(
        Tridiagonal(_shift_last(cosines, 1.0), beside),
        Tridiagonal(_shift_last(odd, -1.0), _ones(half - 1)),
    )


