"""Phases exp(-iπpk/2), exact for any order: k·p is reduced modulo 4 before any cosine."""

from __future__ import annotations

import math

import torch
from torch import Tensor

_GRID = 2.0**30  # k · (p rounded to this grid) is exact in float64 for k < 2**20


def turned_quarters(order: Tensor, indices: Tensor) -> Tensor:
    """k·p modulo 4, in (-8, 8), error below 2e-16: order (..., 1), indices (N,), both float64."""
    order = torch.fmod(order, 4.0)
    coarse = torch.round(order * _GRID) / _GRID
    return torch.addcmul(torch.fmod(coarse * indices, 4.0), order - coarse, indices)


def phases(order: Tensor, indices: Tensor) -> Tensor:
    """exp(-iπpk/2), complex128 (..., N), on the order's device.

    order (...) float64 in quarter turns; indices (N,) float64 on the same device.
    The nearest quarter turn is taken out as an exact factor, so whole turns give exactly ±1, ±i.
    """
    turns = turned_quarters(order[..., None], indices)
    quarter = torch.round(turns)
    angle = (turns - quarter) * (-math.pi / 2)
    quarter = quarter.remainder(4.0)
    # q quarter turns have cosine |q - 2| - 1 and sine 1 - |q - 1|, without rounding
    whole = torch.complex((quarter - 2.0).abs_().sub_(1.0), (quarter - 1.0).abs_().sub_(1.0))
    return torch.complex(torch.cos(angle), torch.sin(angle)).mul_(whole)


def smooth_phases(order: Tensor, indices: Tensor) -> Tensor:
    """The same as one complex128 tensor (..., N) that can be differentiated any number of times.

    The exact value is a constant; the second factor is 1, with the derivative -iπk/2 · exp(…).
    """
    with torch.no_grad():
        exact = phases(order, indices)
    step = (order - order.detach())[..., None] * (-math.pi / 2) * indices
    return exact * torch.exp(torch.complex(torch.zeros_like(step), step))
