"""The work in pieces that stay in the cache: rows of coefficients with the phases they need."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import torch
from torch import Tensor

from omnivat.fractional.phases import phases

_ELEMENTS = 2**16  # of one real plane; with its scratch it fills a core's second-level cache
_ROWS_WORTH_A_LOOP = 16


@dataclass(frozen=True)
class Piece:
    """Some rows (b, N) of coefficients, where they go, and their phases (1 or b, N)."""

    rows: slice
    values: Tensor
    real: Tensor
    imaginary: Tensor


def rows_at_once(size: int, device: torch.device) -> int:
    """How many rows of N samples one piece holds; an accelerator takes all at once."""
    if device.type != "cpu":
        return 2**31
    return max(16, _ELEMENTS * torch.get_num_threads() // size)


def slices(count: int, size: int, device: torch.device) -> Iterator[slice]:
    """Cut `count` rows of N samples."""
    step = rows_at_once(size, device)
    for start in range(0, count, step):
        yield slice(start, min(start + step, count))


def leading_shape(values: Tensor, order: Tensor) -> torch.Size:
    """The batch of the result: the leading axes of the values and the order's, broadcast."""
    return torch.broadcast_shapes(values.shape[:-1], order.shape)


def _cast_phases(order: Tensor, indices: Tensor, like: Tensor) -> tuple[Tensor, Tensor]:
    real, imaginary = phases(order, indices)
    kind = like.dtype.to_real()
    return real.to(kind), imaginary.to(kind)


def pieces(values: Tensor, order: Tensor, indices: Tensor) -> Iterator[Piece]:
    """All rows of the broadcast batch, in order. values (..., N), order (...) float64.

    Phases are computed once an order where many rows share it, else row by row.
    """
    size = values.shape[-1]
    lead = leading_shape(values, order)
    if not math.prod(lead):
        return
    order = order.reshape((1,) * (len(lead) - order.dim()) + order.shape)
    shared = len(lead)  # trailing axes on which the order does not vary
    while shared and order.numel() > 1 and order.shape[len(lead) - shared] != 1:
        shared -= 1
    while shared and any(length != 1 for length in order.shape[len(lead) - shared :]):
        shared -= 1
    count = math.prod(lead[len(lead) - shared :])
    whole = values.expand(*lead, size)
    if order.numel() == 1 or count >= _ROWS_WORTH_A_LOOP:
        outer = lead[: len(lead) - shared]
        each = order.expand(*outer, *(1,) * shared).reshape(-1, 1)
        groups = [whole] if not outer else list(whole.flatten(0, len(outer) - 1)) if values.shape[
            :-1
        ] == lead else [whole[index] for index in _places(outer)]
        for number, group in enumerate(groups):
            real, imaginary = _cast_phases(each[number], indices, values)
            flat = group.reshape(-1, size)
            for rows in slices(count, size, values.device):
                there = slice(number * count + rows.start, number * count + rows.stop)
                yield Piece(there, flat[rows], real, imaginary)
        return
    flat, each = whole.reshape(-1, size), order.expand(lead).reshape(-1)
    for rows in slices(len(flat), size, values.device):
        yield Piece(rows, flat[rows], *_cast_phases(each[rows], indices, values))
