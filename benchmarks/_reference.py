"""The transform in 80-bit arithmetic, independent of the library, as the reference for errors.

Accurate to about 1e-18; checked against 40-digit mpmath by tests/golden/make_fractional.py.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

Long = NDArray[Any]  # np.longdouble: 64 bits of mantissa on x86


@dataclass(frozen=True)
class ReferenceBasis:
    """First-half samples of even (E, E) and odd (O, O) eigenvectors, and k of their columns."""

    even: Long
    odd: Long
    even_indices: list[int]
    odd_indices: list[int]


def _polished(diagonal: Long, beside: Long) -> Long:
    """Return the eigenvectors of a tridiagonal matrix, by decreasing eigenvalue, in 80 bits."""
    size = len(diagonal)
    dense = np.diag(diagonal.astype(float))
    for i in range(size - 1):
        dense[i, i + 1] = dense[i + 1, i] = float(beside[i])
    values, rough = np.linalg.eigh(dense)
    x, theta = rough.astype(np.longdouble), values.astype(np.longdouble)
    for _ in range(2):
        product = diagonal[:, None] * x
        product[:-1] += beside[:, None] * x[1:]
        product[1:] += beside[:, None] * x[:-1]
        norms = (x * x).sum(0)
        theta = (x * product).sum(0) / norms
        residual = (product - theta * x).astype(float)
        gaps = (theta[None, :] - theta[:, None]).astype(float)
        np.fill_diagonal(gaps, np.inf)
        plain = x.astype(float)
        x = (x + plain @ ((plain.T @ residual) / gaps)) / np.sqrt(norms)
    return x[:, ::-1]


@functools.lru_cache(maxsize=2)
def reference_basis(size: int) -> ReferenceBasis:
    """Return the eigenvectors for length N, even and odd."""
    half, paired = size // 2 + 1, (size - 1) // 2
    root, one = np.sqrt(np.longdouble(2)), np.longdouble(1)
    pi = 2 * np.arcsin(one)
    cosines = 2 * np.cos(2 * pi * np.arange(half).astype(np.longdouble) / size)
    even, odd = cosines.copy(), cosines[1 : paired + 1].copy()
    beside = np.full(max(half - 1, 0), one)
    if size == 2:
        beside[0] = 2
    elif size > 2:
        beside[0] = root
        if size % 2:
            even[-1] += 1
            odd[-1] -= 1
        else:
            beside[-1] = root
    e = _polished(even, beside)
    o = _polished(odd, np.full(max(paired - 1, 0), one)) if paired else np.zeros((0, 0))
    e[1 : paired + 1] /= root
    return ReferenceBasis(
        e, o / root, [2 * i for i in range(half)], [2 * i + 1 for i in range(paired)]
    )


def _turned(indices: list[int], order: float) -> tuple[Long, Long]:
    """Return cos and sin of -πpk/2, with k·p reduced modulo 4 in whole numbers."""
    pi = 2 * np.arcsin(np.longdouble(1))
    angles = []
    for k in indices:
        turn = (Fraction(order) * k) % 4
        turn = turn - 4 if turn > 2 else turn
        high = float(turn)
        angles.append(np.longdouble(high) + np.longdouble(float(turn - Fraction(high))))
    angle = np.array(angles, dtype=np.longdouble) * (pi / 2)
    return np.cos(angle), -np.sin(angle)


def reference_parts(x: NDArray[Any], order: float, power: int = 0) -> tuple[Long, Long]:
    """Return the real and imaginary part of F_p x for real x (..., N), in 80 bits.

    power = 1 gives the derivative in the order instead.
    """
    size = x.shape[-1]
    basis = reference_basis(size)
    x = x.astype(np.longdouble)
    paired = basis.odd.shape[0]
    half = basis.even.shape[0]
    mirrored = x[..., size - paired :][..., ::-1]
    sums = x[..., :half].copy()
    sums[..., 1 : paired + 1] += mirrored
    differences = x[..., 1 : paired + 1] - mirrored
    real, imaginary = np.zeros(x.shape, np.longdouble), np.zeros(x.shape, np.longdouble)
    for block, indices, samples, sign in (
        (basis.even, basis.even_indices, sums, 1),
        (basis.odd, basis.odd_indices, differences, -1),
    ):
        if not indices:
            continue
        c, s = _turned(indices, order)
        if power:  # d/dp (c + is) = -iπk/2 (c + is)
            slope = np.array(indices, np.longdouble) * np.arcsin(np.longdouble(1))
            c, s = slope * s, -slope * c
        z = samples @ block
        for target, phase in ((real, c), (imaginary, s)):
            y = (z * phase) @ block.T
            if sign > 0:
                target[..., :half] += y
                y = y[..., 1 : paired + 1]
            else:
                target[..., 1 : paired + 1] += y
            target[..., size - paired :] += sign * y[..., ::-1]
    return real, imaginary


def reference(x: NDArray[Any], order: float, power: int = 0) -> NDArray[np.complex128]:
    """Return F_p x as `reference_parts` does, rounded to complex128."""
    real, imaginary = reference_parts(x, order, power)
    return real.astype(float) + 1j * imaginary.astype(float)
