"""The work in pieces that stay in the cache: rows of coefficients with the phases they need."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import torch
from torch import Tensor

from omnivat.fractional.phases import phases

_ELEMENTS = 2**16  # of one real plane; with its scratch it fills a core's second-level cache
_WORTH_A_LOOP = 16  # rows; below that, phases row by row cost less than a piece for each order


@dataclass(frozen=True)
class Piece:
    """Some rows (b, N) of coefficients, where they lie, and their phases, (1, N) or (b, N)."""

    rows: slice
    values: Tensor
    real: Tensor
    imaginary: Tensor


def slices(count: int, size: int, device: torch.device) -> Iterator[slice]:
    """Cut `count` rows of N samples for the cache; an accelerator takes all at once."""
    at_once = max(16, _ELEMENTS * torch.get_num_threads() // size)
    step = at_once if device.type == "cpu" else max(count, 1)
    for start in range(0, count, step):
        yield slice(start, min(start + step, count))


def leading_shape(values: Tensor, order: Tensor) -> torch.Size:
    """The batch of the result: the leading axes of the values and the order's, broadcast."""
    return torch.broadcast_shapes(values.shape[:-1], order.shape)


def _cast_phases(order: Tensor, indices: Tensor, like: Tensor) -> tuple[Tensor, Tensor]:
    kind = like.dtype.to_real()
    real, imaginary = phases(order, indices)
    return real.to(kind), imaginary.to(kind)


def pieces(values: Tensor, order: Tensor, indices: Tensor) -> Iterator[Piece]:
    """All rows of the broadcast batch, first to last. values (..., N), order (...) float64.

    Phases are computed once for each order where many rows share it, else row by row.
    """
    lead, size = leading_shape(values, order), values.shape[-1]
    if not math.prod(lead):
        return
    rows = values.expand(*lead, size)
    order = order.reshape((1,) * (len(lead) - order.dim()) + order.shape)
    varying = len(lead) if order.numel() > 1 else 0  # axes up to the last on which it varies
    while varying and order.shape[varying - 1] == 1:
        varying -= 1
    sharing = math.prod(lead[varying:])
    if varying and sharing < _WORTH_A_LOOP:
        yield from _row_by_row(rows.reshape(-1, size), order.expand(lead).reshape(-1), indices)
        return
    orders = order.expand(*lead[:varying], *order.shape[varying:]).reshape(-1, 1)
    places = itertools.product(*(range(length) for length in lead[:varying]))
    for number, place in enumerate(places):
        real, imaginary = _cast_phases(orders[number], indices, values)
        group, start = rows[place].reshape(-1, size), number * sharing
        for some in slices(sharing, size, values.device):
            yield Piece(slice(start + some.start, start + some.stop), group[some], real, imaginary)


def _row_by_row(rows: Tensor, orders: Tensor, indices: Tensor) -> Iterator[Piece]:
    for some in slices(*rows.shape, rows.device):
        yield Piece(some, rows[some], *_cast_phases(orders[some], indices, rows))
