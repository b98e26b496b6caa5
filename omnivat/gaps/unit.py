"""Scale rows to unit length; shared by the measures."""

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

from omnivat.errors import ShapeError
from omnivat.shapes import unit as scaled

BLOCK = 4096  # rows scaled at once, so that temporaries stay in the cache


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value and its standard error."""

    value: Float[Tensor, ""]
    error: Float[Tensor, ""]


def unit(x: Float[Tensor, "*any D"]) -> Float[Tensor, "*any D"]:
    """Return each row divided by its length, denormal to the largest float; a zero row stays zero."""
    if x.ndim == 2 and len(x) > BLOCK and not x.requires_grad:
        out = torch.empty_like(x)
        for rows, into in zip(x.split(BLOCK), out.split(BLOCK), strict=True):
            into.copy_(scaled(rows))
        return out
    return scaled(x)


def require_rows(least: int, **sets: Tensor) -> None:
    """Raise ShapeError for sets with fewer than `least` rows; the message names them."""
    for name, rows in sets.items():
        if len(rows) < least:
            raise ShapeError(f"{name} has {len(rows)} rows; this measure needs {least} or more. Choose a larger set.")
