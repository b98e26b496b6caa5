"""Phases exp(-iπpk/2), exact for any order: k·p is reduced modulo 4 before any cosine."""

from __future__ import annotations

import math

import torch
from jaxtyping import Complex128, Float64
from torch import Tensor

_GRID = 2.0**30  # k · (p rounded to this grid) is exact in float64 for k < 2**20


def phases(
    order: Float64[Tensor, "*own"], indices: Float64[Tensor, " N"]
) -> Complex128[Tensor, "*own N"]:
    """Return exp(-iπpk/2) of orders in quarter turns, on their device.

    The nearest quarter turn is an exact factor, so whole orders give exactly ±1 and ±i.
    """
    order = torch.fmod(order[..., None], 4.0)
    coarse = torch.round(order * _GRID) / _GRID
    # k·p modulo 4 in (-8, 8), error below 2e-16
    turns = torch.addcmul(torch.fmod(coarse * indices, 4.0), order - coarse, indices)
    quarter = torch.round(turns)
    angle = (turns - quarter) * (-math.pi / 2)
    quarter = quarter.remainder(4.0)
    # q quarter turns have cosine |q - 2| - 1 and sine 1 - |q - 1|, without rounding
    whole = torch.complex((quarter - 2.0).abs_().sub_(1.0), (quarter - 1.0).abs_().sub_(1.0))
    return torch.complex(torch.cos(angle), torch.sin(angle)).mul_(whole)


def smooth_phases(
    order: Float64[Tensor, "*own"], indices: Float64[Tensor, " N"]
) -> Complex128[Tensor, "*own N"]:
    """Return the same phases, differentiable any number of times.

    The exact value is a constant. A second factor of value 1 has the derivative -iπk/2 · exp(…).
    """
    fixed = order.detach()
    exact = phases(fixed, indices)
    step = (order - fixed)[..., None] * (-math.pi / 2) * indices
    return exact * torch.exp(1j * step)  # `torch.complex` has no gradient under `jacfwd`
