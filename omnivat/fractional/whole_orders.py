"""Orders 0, 1, 2 and 3 (mod 4): identity, FFT, reversal and inverse FFT, without a matrix."""

from __future__ import annotations

import functools
import math
from typing import Any

import torch
from torch import Tensor

from omnivat.fractional.arguments import readable


def whole_turns(order: float | Tensor | Any) -> int | None:
    """Return 0, 1, 2 or 3 if the order is a single whole number (mod 4), else None.

    An order that cannot be read (`arguments.readable`) gives None.
    """
    if isinstance(order, Tensor):
        if order.dim() or order.is_complex() or not readable(order):
            return None
        order = order.item()
    if isinstance(order, int):
        return order % 4
    if isinstance(order, float) and math.isfinite(order) and order.is_integer():
        return int(math.fmod(order, 4.0)) % 4
    return None


@functools.lru_cache(maxsize=1024)
def fft_is_exact(size: int) -> bool:
    """True if the library's FFT of that length is accurate on every processor.

    That requires that no prime factor exceeds 13. For larger ones, MKL loses up to two digits in
    float64 on processors with AVX-512 (1.8e-14 at N = 511 = 7 · 73); the eigenbasis is used then.
    """
    for prime in (2, 3, 5, 7, 11, 13):
        while size % prime == 0:
            size //= prime
    return size == 1


def quarter_turn(x: Tensor, turns: int, dim: int, *, centered: bool) -> Tensor:
    """Return the transform of order `turns` along dim as a new complex tensor."""
    x = torch.fft.ifftshift(x, dim) if centered else x
    if turns == 0:
        result = x.to(x.dtype.to_complex(), copy=True)
    elif turns == 2:
        result = x.flip(dim).roll(1, dim).to(x.dtype.to_complex())
    elif not x.numel():  # MKL refuses a batch of no vectors
        result = x.to(x.dtype.to_complex(), copy=True)
    else:
        transform = torch.fft.fft if turns == 1 else torch.fft.ifft
        # the inverse of real input is a lazy conjugate, which has no `.numpy()`
        result = transform(x, dim=dim, norm="ortho").resolve_conj()
    return torch.fft.fftshift(result, dim) if centered else result
