"""The transform: `dfrft`, and its two halves `coefficients` and `synthesise`."""

from __future__ import annotations

import functools
import math

import torch
from torch import Tensor

from omnivat.errors import ShapeError
from omnivat.fractional.coefficients import Coefficients


@functools.lru_cache(maxsize=16)
def _eigenvectors(size: int) -> tuple[Tensor, Tensor]:
    """V (N, N) and its indices k (N,), float64, built by parity halves."""
    v = torch.zeros(size, size, dtype=torch.float64)
    n = torch.arange(size, dtype=torch.float64)
    s = torch.diag(2 * torch.cos(2 * math.pi * n / size))
    for i in range(size):
        s[i, (i + 1) % size] += 1
        s[i, (i - 1) % size] += 1
    even, odd = size // 2 + 1, (size - 1) // 2
    fold = torch.zeros(size, size, dtype=torch.float64)
    fold[0, 0] = 1
    for j in range(1, odd + 1):
        fold[j, j] = fold[size - j, j] = math.sqrt(0.5)
        fold[j, even + j - 1], fold[size - j, even + j - 1] = math.sqrt(0.5), -math.sqrt(0.5)
    if size % 2 == 0:
        fold[size // 2, size // 2] = 1
    t = fold.T @ s @ fold
    v[:, :even] = fold[:, :even] @ torch.linalg.eigh(t[:even, :even])[1].flip(-1)
    if odd:
        v[:, even:] = fold[:, even:] @ torch.linalg.eigh(t[even:, even:])[1].flip(-1)
    k = torch.cat([2 * torch.arange(even), 2 * torch.arange(odd) + 1]).to(torch.float64)
    return v, k


def _working(x: Tensor) -> Tensor:
    """x in the precision of the computation: half and integers become float32."""
    if x.dtype in (torch.float32, torch.float64, torch.complex64, torch.complex128):
        return x
    return x.to(torch.complex64 if x.is_complex() else torch.float32)


def coefficients(x: Tensor, dim: int = -1) -> Coefficients:
    """The part of the transform that does not depend on the order.

    x: any shape; dim: the axis of length N that is transformed.
    """
    x = _working(x)
    if x.dim() == 0 or x.shape[dim] == 0:
        raise ShapeError(f"x has shape {tuple(x.shape)}, expected an axis of one or more samples.")
    dim = dim - x.dim() if dim >= 0 else dim
    x = x.movedim(dim, -1)
    v = _eigenvectors(x.shape[-1])[0].to(x)
    return Coefficients(x @ v, dim)


def synthesise(
    coefficients: Coefficients, order: float | Tensor, *, planar: bool = False
) -> Tensor:
    """The transform of order `order` of the vectors whose coefficients are given.

    order: a number, or a tensor that broadcasts against the leading axes: (B,) is one order per
    row of (B, N); (P, 1) gives P transforms of all rows, (P, B, N).
    planar: give real and imaginary parts stacked, real (2, ..., N), instead of complex (..., N).
    """
    c = coefficients.values
    v, k = _eigenvectors(coefficients.size)
    p = torch.as_tensor(order, dtype=torch.float64, device=c.device)
    if not bool(torch.isfinite(p).all()):
        raise ShapeError(f"The order is {order}, expected finite numbers.")
    turns = torch.fmod(p, 4)[..., None] * k.to(c.device)
    phase = torch.polar(torch.ones_like(turns), -math.pi / 2 * torch.fmod(turns, 4))
    wide = torch.complex128 if c.dtype in (torch.float64, torch.complex128) else torch.complex64
    z = c * phase.to(wide)
    real = torch.stack([z.real, z.imag]) @ v.to(z.real).T
    if planar:
        return real.movedim(-1, coefficients.dim)
    return torch.complex(real[0], real[1]).movedim(-1, coefficients.dim)


def dfrft(x: Tensor, order: float | Tensor, dim: int = -1, *, planar: bool = False) -> Tensor:
    """The discrete fractional Fourier transform of x along dim; order 1 is the unitary DFT."""
    return synthesise(coefficients(x, dim), order, planar=planar)
