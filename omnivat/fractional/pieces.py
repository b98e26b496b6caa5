"""The work in pieces that stay in the cache: rows of coefficients with the phases they need."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import torch
from torch import Tensor

from omnivat.fractional.phases import phases

_ELEMENTS = 2**17  # of one real plane; with its scratch it fills a core's second-level cache
_WORTH_A_LOOP = 16  # rows; below that, phases row by row cost less than a piece for each order


@dataclass(frozen=True)
class Piece:
    """Some rows of coefficients.

    rows: where they lie in the broadcast batch; values (b, N); orders (1 or b,); shared: the phases
    if other pieces have the same, else they are left to whoever works on the piece.
    """

    rows: slice
    values: Tensor
    orders: Tensor
    indices: Tensor
    shared: Tensor | None = None

    def phases(self) -> Tensor:
        """Real and imaginary part of exp(-iπpk/2), (2, 1 or b, N)."""
        if self.shared is not None:
            return self.shared
        return _planar_phases(self.orders, self.indices, self.values)


def slices(rows: Tensor) -> Iterator[slice]:
    """Cut rows (R, N) for the cache; an accelerator takes all at once."""
    count, size = rows.shape
    step = max(16, _ELEMENTS // size) if rows.device.type == "cpu" else max(count, 1)
    for start in range(0, count, step):
        yield slice(start, min(start + step, count))


def leading_shape(values: Tensor, order: Tensor) -> torch.Size:
    """The batch of the result: the leading axes of the values and the order's, broadcast."""
    if not order.dim():  # broadcast_shapes is written in Python and slow
        return values.shape[:-1]
    shape: torch.Size = torch.broadcast_shapes(values.shape[:-1], order.shape)
    return shape


def _planar_phases(order: Tensor, indices: Tensor, like: Tensor) -> Tensor:
    """Phases of orders (b,) as planes (2, b, N), cast to the precision of the values."""
    both = torch.view_as_real(phases(order, indices)).movedim(-1, 0)
    return both.to(like.dtype.to_real(), memory_format=torch.contiguous_format, copy=True)


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
    orders = order.expand((*lead[:varying], *order.shape[varying:])).reshape(-1, 1)
    places = itertools.product(*(range(length) for length in lead[:varying]))
    for number, place in enumerate(places):
        turned = _planar_phases(orders[number], indices, values)
        group, start = rows[place].reshape(-1, size), number * sharing
        for some in slices(group):
            place_of_some = slice(start + some.start, start + some.stop)
            yield Piece(place_of_some, group[some], orders[number], indices, turned)


def _row_by_row(rows: Tensor, orders: Tensor, indices: Tensor) -> Iterator[Piece]:
    for some in slices(rows):
        yield Piece(some, rows[some], orders[some], indices)
