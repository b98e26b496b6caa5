"""Eigenvectors of a parity block: LAPACK, then one correction with a doubled residual.

LAPACK leaves an error of about eps/gap (3e-14 at N = 1024). One step of first-order perturbation
theory squares that error away, provided that its residual is known beyond float64.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from omnivat.fractional.commuting import Tridiagonal
from omnivat.fractional.doubled import Array, Pair, add, exact_product, excess_norm

_COLUMNS = 128  # doubled arithmetic makes dozens of passes; so many columns stay in the cache


@dataclass(frozen=True)
class Spectrum:
    """Eigenvalues (n), falling, and eigenvectors (n, n) of unit length in columns."""

    values: Array
    vectors: Array


def blocks_of_columns(count: int) -> Iterator[slice]:
    """Slices that cover `count` columns, few enough at a time for the cache."""
    for start in range(0, count, _COLUMNS):
        yield slice(start, min(start + _COLUMNS, count))


def lapack_spectrum(block: Tridiagonal) -> Spectrum:
    """Both to float64 accuracy by divide and conquer (`dstevd`).

    The faster `dstemr` loses orthogonality at N = 4096, or fails when asked for half a spectrum.
    """
    from scipy.linalg import lapack

    if len(block) < 2:
        return Spectrum(block.diagonal.high.copy(), np.ones((len(block), len(block))))
    values, vectors, info = lapack.dstevd(block.diagonal.high, block.beside)
    if info:
        raise ArithmeticError(f"LAPACK dstevd failed with info = {info} at size {len(block)}.")
    return Spectrum(values[::-1], vectors[:, ::-1])


def residual(product: Pair, values: Array, vectors: Array) -> Array:
    """product - vectors · diag(values), rounded only at the end."""
    scaled = exact_product(-values[None, :], vectors)
    total = add(product, scaled)
    return np.asarray(total.high + total.low)


def inverse_gaps(values: Array) -> Array:
    """1 / (values[k] - values[i]) at row i, column k; zero on the diagonal."""
    gaps = values[None, :] - values[:, None]
    np.fill_diagonal(gaps, np.inf)
    return np.asarray(1.0 / gaps)


def refined_spectrum(block: Tridiagonal) -> Array:
    """Eigenvectors of a tridiagonal block, (n, n), by falling eigenvalue, right to an ulp or two."""
    rough = lapack_spectrum(block)
    x = rough.vectors
    if len(block) < 2:
        return x
    off, excess = np.empty_like(x), np.empty(len(block))
    for columns in blocks_of_columns(len(block)):
        part = x[:, columns]
        off[:, columns] = residual(block.times(part), rough.values[columns], part)
        excess[columns] = excess_norm(part)
    shift = (x * off).sum(0)
    mixing = (x.T @ (off - x * shift)) * inverse_gaps(rough.values + shift)
    return np.asarray(x + (x @ mixing - x * excess))
