"""Phases exp(-iπpk/2), exact for any order: k·p is reduced modulo 4 before any cosine."""

from __future__ import annotations

import math

import torch
from torch import Tensor

_GRID = 2.0**30  # k · (p rounded to this grid) is exact in float64 for k < 2**20


def turned_quarters(order: Tensor, indices: Tensor) -> Tensor:
    """Return k·p modulo 4 in (-8, 8), error below 2e-16; order (..., 1), indices (N,), float64."""
    order = torch.fmod(order, 4.0)
    coarse = torch.round(order * _GRID) / _GRID
    return torch.addcmul(torch.fmod(coarse * indices, 4.0), order - coarse, indices)


def phases(order: Tensor, indices: Tensor) -> Tensor:
    """exp(-iπpk/2), complex128 (..., N), on the order's device.

    order (...) float64 in quarter turns; indices (N,) float64 on the same device.
    The nearest quarter turn is an exact factor, so whole orders give exactly ±1 and ±i.
    """
    turns = turned_quarters(order[..., None], indices)
    quarter = torch.round(turns)
    angle = (turns - quarter) * (-math.pi / 2)
    quarter = quarter.remainder(4.0)
    # q quarter turns have cosine |q - 2| - 1 and sine 1 - |q - 1|, without rounding
    whole = torch.complex((quarter - 2.0).abs_().sub_(1.0), (quarter - 1.0).abs_().sub_(1.0))
    return torch.complex(torch.cos(angle), torch.sin(angle)).mul_(whole)


def smooth_phases(order: Tensor, indices: Tensor) -> Tensor:
    """Return the same phases, (..., N) complex128, differentiable any number of times.

    The exact value is a constant. A second factor of value 1 has the derivative -iπk/2 · exp(…).
    """
    with torch.no_grad():
        exact = phases(order, indices)
    step = (order - order.detach())[..., None] * (-math.pi / 2) * indices
    return exact * torch.exp(torch.complex(torch.zeros_like(step), step))
