"""Eigenvectors of a parity block, whole or in halves: LAPACK, then one correction.

LAPACK has an error of about eps/gap (3e-14 at N = 1024). One step of first-order perturbation
theory squares the error, provided that the residual is more accurate than float64.

For N = 4M a block splits into halves again. The reversal with alternating signs Q,
(Qv)_j = (-1)^j v_{n-1-j}, anticommutes with a parity block T of S. So T maps Q = +1 to Q = -1 and
back: T = [[0, Bᵀ], [B, 0]]. A singular triplet B w = σ u, Bᵀ u = σ w gives two eigenvectors,
(w, u)/√2 and (w, -u)/√2, with eigenvalues σ and -σ. The middle sample adds the null vector of B
to one side. Derivation: docs/fractional.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from omnivat.fractional.commuting import Tridiagonal
from omnivat.fractional.double_double import (
    SQRT2,
    Array,
    Pair,
    add,
    exact_product,
    excess_norm,
    multiply,
)


def lapack_spectrum(
    block: Tridiagonal,
) -> tuple[Float64[np.ndarray, " n"], Float64[np.ndarray, "n n"]]:
    """Return eigenvalues, decreasing, and unit eigenvectors in columns, to float64 accuracy.

    By divide and conquer (`dstevd`).

    The faster `dstemr` loses orthogonality at N = 4096, and fails for half a spectrum.
    """
    from scipy.linalg import eigh_tridiagonal

    values, vectors = eigh_tridiagonal(
        block.diagonal.high, block.beside, lapack_driver="stevd", check_finite=False
    )
    return values[::-1], vectors[:, ::-1]


def residual(
    product: Pair, values: Float64[np.ndarray, " m"], vectors: Float64[np.ndarray, "n m"]
) -> Float64[np.ndarray, "n m"]:
    """Return product - vectors · diag(values), rounded only at the end."""
    scaled = exact_product(-values[None, :], vectors)
    total = add(product, scaled)
    return np.asarray(total.high + total.low)


def inverse_gaps(values: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, "n n"]:
    """Return 1 / (values[k] - values[i]) at row i, column k; zero on the diagonal."""
    gaps = values[None, :] - values[:, None]
    np.fill_diagonal(gaps, np.inf)
    return np.asarray(1.0 / gaps)


def refined_spectrum(block: Tridiagonal) -> Float64[np.ndarray, "n n"]:
    """Return eigenvectors of a tridiagonal block, by decreasing eigenvalue, to 1-2 ulp."""
    if len(block) < 2:
        return np.ones((len(block), len(block)))
    values, x = lapack_spectrum(block)
    off = residual(block.times(x), values, x)
    shift = (x * off).sum(0)
    mixing = (x.T @ (off - x * shift)) * inverse_gaps(values + shift)
    return np.asarray(x + (x @ mixing - x * excess_norm(x)))


class QuarterFactor(NamedTuple):
    """Unit singular vectors of one parity block in columns, by decreasing σ.

    large (w = m + 1): m vectors, then the null vector; rows are samples, the middle one last.
    small: their partners. `large` belongs to Q = +1 if m is even, to Q = -1 if m is odd.
    """

    large: Float64[np.ndarray, "w w"]
    small: Float64[np.ndarray, "m m"]


def alternating(size: int) -> Float64[np.ndarray, " {size}"]:
    """Return 1, -1, 1, …"""
    return 1.0 - 2.0 * (np.arange(size) % 2)


def _rough(block: Tridiagonal) -> tuple[Array, QuarterFactor]:
    """Return singular values (m) and vectors from LAPACK's eigenvectors of the whole block."""
    m = len(block) // 2
    values, vectors = lapack_spectrum(block)
    pairs = vectors[:, :m]
    null = np.append(np.sqrt(2.0) * vectors[:m, m], vectors[m, m])[:, None]
    mirrored = alternating(m)[:, None] * pairs[:m:-1]
    plus, minus = pairs[:m] + mirrored, pairs[:m] - mirrored
    large, small = (plus, minus) if m % 2 == 0 else (minus, plus)
    large = np.hstack([np.vstack([large, np.sqrt(2.0) * pairs[m]]), null])
    return values[:m], QuarterFactor(large, small)


def _to_small(block: Tridiagonal, large: Float64[np.ndarray, "w c"]) -> Pair:
    """Return B times vectors of the large side."""
    y = block.times(large[:-1])
    middle = multiply(Pair(large[-1:], 0 * large[-1:]), SQRT2)
    y.high[-1:], y.low[-1:] = add(y.part(slice(-1, None)), middle)
    return y


def _to_large(block: Tridiagonal, small: Float64[np.ndarray, "m c"]) -> Pair:
    """Return Bᵀ times vectors of the small side."""
    y = block.times(small)
    middle = multiply(Pair(small[-1:], 0 * small[-1:]), SQRT2)
    return Pair(np.vstack([y.high, middle.high]), np.vstack([y.low, middle.low]))


def refined_quarter(block: Tridiagonal) -> QuarterFactor:
    """Return the singular vectors of a parity block of size n = 2m + 1 ≥ 3, to 1-2 ulp."""
    values, rough = _rough(block)
    leading = block.leading(len(values))
    w, u, null = rough.large[:, :-1], rough.small, rough.large[:, -1:]
    off_u = residual(_to_small(leading, w), values, u)
    off_w = residual(_to_large(leading, u), values, w)
    shift = 0.5 * ((u * off_u).sum(0) + (w * off_w).sum(0))
    sigma = values + shift
    off_u -= u * shift
    off_w -= w * shift
    # First-order corrections along the others (w, u), their mirrors (w, -u), and the null vector.
    with_w, with_u = w.T @ off_w, u.T @ off_u
    same = 0.5 * (with_w + with_u) * inverse_gaps(sigma)
    sums = sigma[None, :] + sigma[:, None]
    np.fill_diagonal(sums, np.inf)  # it would only rescale w against u: see `excess`
    mirror = 0.5 * (with_w - with_u) / sums
    new_w = w + (w @ (same + mirror) + null * ((null.T @ off_w) / sigma) - w * excess_norm(w))
    new_u = u + (u @ (same - mirror) - u * excess_norm(u))
    leak = _to_small(leading, null)
    away = w @ ((u.T @ (leak.high + leak.low)) / sigma[:, None])
    new_null = null - (away + null * excess_norm(null))
    return QuarterFactor(np.hstack([new_w, new_null]), new_u)
