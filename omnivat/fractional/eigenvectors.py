"""Eigenvectors of a parity block: LAPACK, then one correction with a doubled residual.

LAPACK leaves an error of about eps/gap (3e-14 at N = 1024). One step of first-order perturbation
theory squares that error away, provided that its residual is known beyond float64.
"""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module

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


@functools.cache
def _dstevd() -> Callable[..., None]:
    """LAPACK's `dstevd` at its address: scipy's wrapper keeps Python's lock, a ctypes call frees it.

    Source: scipy.linalg.cython_lapack, which offers its routines in this way.
    """
    capsule = import_module("scipy.linalg.cython_lapack").__pyx_capi__["dstevd"]
    python = ctypes.pythonapi
    python.PyCapsule_GetName.restype = ctypes.c_char_p
    python.PyCapsule_GetName.argtypes = [ctypes.py_object]
    python.PyCapsule_GetPointer.restype = ctypes.c_void_p
    python.PyCapsule_GetPointer.argtypes = [ctypes.py_object, ctypes.c_char_p]
    address = python.PyCapsule_GetPointer(capsule, python.PyCapsule_GetName(capsule))
    return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 11)(address)


def lapack_spectrum(block: Tridiagonal) -> Spectrum:
    """Both to float64 accuracy by divide and conquer (`dstevd`).

    The faster `dstemr` loses orthogonality at N = 4096, or fails when asked for half a spectrum.
    """
    n = len(block)
    if n < 2:
        return Spectrum(block.diagonal.high.copy(), np.ones((n, n)))
    values, beside, vectors = block.diagonal.high.copy(), block.beside, np.empty((n, n))
    work, whole = np.empty(1 + 4 * n + n * n), np.empty(3 + 5 * n, np.int32)
    sizes = np.array([n, n, len(work), len(whole), 0], np.int32)  # n, ldz, lwork, liwork, info
    size, stride, length, count, info = (sizes[i : i + 1].ctypes.data for i in range(5))
    arrays = (a.ctypes.data for a in (values, beside, vectors))
    _dstevd()(b"V", size, *arrays, stride, work.ctypes.data, length, whole.ctypes.data, count, info)
    if sizes[4]:
        raise ArithmeticError(f"LAPACK dstevd failed with info = {sizes[4]} at size {n}.")
    return Spectrum(values[::-1], vectors.T[:, ::-1])  # LAPACK writes columns


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
