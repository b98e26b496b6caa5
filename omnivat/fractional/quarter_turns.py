"""Orders 0, 1, 2 and 3 (mod 4): identity, FFT, reversal and inverse FFT, without a matrix."""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor


def whole_turns(order: float | Tensor | Any) -> int | None:
    """0, 1, 2 or 3 if the order is one whole number (mod 4), else None.

    An order on an accelerator is not read back, so it never counts as whole.
    """
    if isinstance(order, Tensor):
        if order.dim() or order.device.type != "cpu" or order.is_complex():
            return None
        order = order.item()
    if isinstance(order, int):
        return order % 4
    if isinstance(order, float) and math.isfinite(order) and order.is_integer():
        return int(math.fmod(order, 4.0)) % 4
    return None


def quarter_turn(x: Tensor, turns: int, dim: int, *, centered: bool) -> Tensor:
    """The transform of order `turns` along dim, complex and a new tensor."""
    x = torch.fft.ifftshift(x, dim) if centered else x
    if turns == 0:
        result = x.to(x.dtype.to_complex(), copy=True)
    elif turns == 2:
        result = x.flip(dim).roll(1, dim).to(x.dtype.to_complex())
    else:
        transform = torch.fft.fft if turns == 1 else torch.fft.ifft
        result = transform(x, dim=dim, norm="ortho")
    return torch.fft.fftshift(result, dim) if centered else result
