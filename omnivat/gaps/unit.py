"""Put rows on the unit sphere, whatever their length."""

import torch
from torch import Tensor

from omnivat.errors import ShapeError

BLOCK = 4096  # rows made unit at once: what lies between stays in the processor's cache


def unit(x: Tensor) -> Tensor:
    """Return each row divided by its length.

    x       (..., D) real, of any length, down to denormal and up to the largest float
    return  (..., D); a zero row stays zero
    """
    if x.ndim == 2 and len(x) > BLOCK and not x.requires_grad:
        out = torch.empty_like(x)
        for rows, into in zip(x.split(BLOCK), out.split(BLOCK), strict=True):
            into.copy_(_unit(rows))
        return out
    return _unit(x)


def _unit(x: Tensor) -> Tensor:
    largest = x.abs().amax(-1, keepdim=True)
    # dividing twice keeps the squares of huge and tiny rows inside the floating range
    x = x / largest.where(largest > 0, 1)
    length: Tensor = x.norm(dim=-1, keepdim=True)
    return x / length.where(length > 0, 1)


def require_rows(least: int, **sets: Tensor) -> None:
    """Refuse sets of fewer than `least` rows, by name. Raises ShapeError."""
    for name, rows in sets.items():
        if len(rows) < least:
            raise ShapeError(
                f"{name} has {len(rows)} rows; this measure needs {least} or more. "
                "Choose a larger set."
            )
