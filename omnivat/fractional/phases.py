"""Phases exp(-iπpk/2), exact for any order: k·p is reduced modulo 4 before any cosine."""

from __future__ import annotations

import math

import torch
from torch import Tensor

_GRID = 2.0**30  # k · (p rounded to this grid) is exact in float64 for k < 2**20


def turned_quarters(order: Tensor, indices: Tensor) -> Tensor:
    """k·p modulo 4 in (-8, 8), error below 2e-16: order (..., 1) float64, indices (N,) float64."""
    order = torch.fmod(order, 4.0)
    coarse = torch.round(order * _GRID) / _GRID
    return torch.fmod(coarse * indices, 4.0) + (order - coarse) * indices


def phases(order: Tensor, indices: Tensor) -> tuple[Tensor, Tensor]:
    """Real and imaginary part of exp(-iπpk/2), each (..., N), float64, on the order's device.

    order (...) float64 in quarter turns; indices (N,) float64 on the same device.
    The nearest quarter turn is taken out exactly, so that whole turns give exactly 0 and ±1.
    """
    turns = turned_quarters(order[..., None], indices)
    quarter = torch.round(turns)
    rest = (turns - quarter) * (math.pi / 2)
    cosine, sine = torch.cos(rest), torch.sin(rest)
    quarter = torch.remainder(quarter, 4.0)
    swapped = torch.remainder(quarter, 2.0) == 1.0
    real = torch.where(swapped, sine, cosine)
    imaginary = torch.where(swapped, cosine, sine)
    # (-i)^q (c - is): q = 0: (c, -s), 1: (-s, -c), 2: (-c, s), 3: (s, c)
    real = torch.where((quarter == 1.0) | (quarter == 2.0), -real, real)
    imaginary = torch.where(quarter < 2.0, -imaginary, imaginary)
    return real, imaginary


def smooth_phases(order: Tensor, indices: Tensor) -> Tensor:
    """The same as one complex128 tensor (..., N) that can be differentiated any number of times.

    The exact value is a constant; the second factor is 1, with the derivative -iπk/2 · exp(…).
    """
    with torch.no_grad():
        real, imaginary = phases(order, indices)
    step = (order - order.detach())[..., None] * (-math.pi / 2) * indices
    return torch.complex(real, imaginary) * torch.exp(torch.complex(torch.zeros_like(step), step))
