"""Apply V and Vᵀ to whole batches, without a graph.

A batch is processed in pieces that fit the cache: rows of coefficients with their phases.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float, Float64, Inexact
from torch import Tensor

from omnivat.fractional.phases import phases
from omnivat.fractional.splits import Split
from omnivat.fractional.workers import for_each

_ELEMENTS = 2**17  # of one real plane; with its scratch space it fills a core's L2 cache
_WORTH_WORKERS = 2**18  # numbers in the result; fewer are not worth a second thread


class Piece(NamedTuple):
    """Some rows of coefficients: g orders, and b rows of each.

    rows: their place in the broadcast batch; phases: returns cos and sin of -πpk/2, as planes.
    """

    rows: slice
    values: Inexact[Tensor, "g b N"]
    phases: Callable[[], Float[Tensor, "2 g 1 N"]]


def slices(rows: Inexact[Tensor, "R N"]) -> Iterator[slice]:
    """Split rows into slices for the cache; on an accelerator, one slice."""
    count, step = len(rows), _at_once(rows)
    for start in range(0, count, step):
        yield slice(start, min(start + step, count))


def _at_once(rows: Inexact[Tensor, "... N"]) -> int:
    """Return the number of rows in a piece."""
    size = rows.shape[-1]
    return max(16, _ELEMENTS // size) if rows.device.type == "cpu" else max(rows[..., 0].numel(), 1)


def _planar_phases(
    order: Float64[Tensor, " g"], indices: Float64[Tensor, " N"], like: Tensor
) -> Float[Tensor, "2 g 1 N"]:
    """Return phases as planes, cast to the precision of the values."""
    both = torch.view_as_real(phases(order[:, None], indices)).movedim(-1, 0)
    return both.to(like.dtype.to_real(), memory_format=torch.contiguous_format, copy=True)


def pieces(
    values: Inexact[Tensor, "... N"],
    order: Float64[Tensor, "..."],
    lead: torch.Size,
    indices: Float64[Tensor, " N"],
) -> Iterator[Piece]:
    """Yield all rows of the batch of shape `lead`, to which values and order broadcast, in order.

    The phases of an order are computed once. A piece holds several orders if the rows that share
    an order are too few to fill it.
    """
    size = values.shape[-1]
    rows = values.expand(*lead, size)
    order = order.view((1,) * (len(lead) - order.dim()) + order.shape)
    varying = len(lead)  # axes along which it varies
    while varying and order.shape[varying - 1] == 1:
        varying -= 1
    sharing = math.prod(lead[varying:])
    orders = order.view(order.shape[:varying]).expand(lead[:varying])
    together = _at_once(rows) // max(sharing, 1)
    if varying and together > 1:
        groups, each = rows.reshape(-1, sharing, size), orders.flatten()
        for start in range(0, len(each), together):
            own = each[start : start + together]
            part = slice(start * sharing, (start + len(own)) * sharing)
            found = partial(_planar_phases, own, indices, values)
            yield Piece(part, groups[start : start + together], found)
        return
    for number, place in enumerate(np.ndindex(lead[:varying])):
        shared = _planar_phases(orders[place][None], indices, values)
        group, start = rows[place].reshape(-1, size), number * sharing
        for some in slices(group):
            place_of_some = slice(start + some.start, start + some.stop)
            yield Piece(place_of_some, group[some][None], lambda shared=shared: shared)  # type: ignore[misc]


def planes(x: Inexact[Tensor, "*any"]) -> Float[Tensor, "#2 *any"]:
    """Return the real and imaginary part, stacked; of real x, the real part alone."""
    return torch.stack([x.real, x.imag]) if x.is_complex() else x[None]


def _spread(rows: Tensor) -> bool:
    """True if rows are enough for several threads."""
    return rows.device.type == "cpu" and rows.numel() >= _WORTH_WORKERS


def product_rows(
    split: Split, x: Inexact[Tensor, "*lead N"], *, back: bool
) -> Inexact[Tensor, "*lead N"]:
    """Return x V, or with `back` x Vᵀ."""
    rows = x.reshape(-1, x.shape[-1])
    out = torch.empty_like(rows, memory_format=torch.contiguous_format)
    apply = split.restore if back else split.analyse

    def work(some: slice) -> None:
        if x.is_complex():
            part = planes(rows[some]).flatten(0, 1)
            product = torch.empty_like(part)
            apply(part, product)
            torch.complex(*product.chunk(2), out=out[some])
        else:
            apply(rows[some].clone() if back else rows[some], out[some])

    for_each(work, slices(rows), spread=_spread(out))
    return out.view(x.shape)


def synthesise_rows(
    split: Split,
    values: Inexact[Tensor, "... N"],
    order: Float64[Tensor, "..."],
    lead: torch.Size,
    *,
    planar: bool,
) -> Inexact[Tensor, "... N"]:
    """Return (λ^p ⊙ values) Vᵀ: planar real (2, *lead, N), else complex (*lead, N)."""
    size, kind = values.shape[-1], values.dtype
    shape = (*lead, size)
    whole, kind = ((2, *shape), kind.to_real()) if planar else (shape, kind.to_complex())
    result = torch.empty(whole, dtype=kind, device=values.device)
    flat = result.view(2, -1, size) if planar else result.view(-1, size)

    def work(piece: Piece) -> None:
        cosine_sine, c = piece.phases(), piece.values
        z = planes(c * torch.complex(*cosine_sine)) if c.is_complex() else c * cosine_sine
        z = z.flatten(1, 2)
        if planar:
            split.restore(z, flat[:, piece.rows])
        else:
            split.restore(z, z)
            torch.complex(*z, out=flat[piece.rows])

    for_each(work, pieces(values, order, lead, split.indices), spread=_spread(result))
    return result


def turned_back(
    split: Split,
    values: Inexact[Tensor, "*lead N"],
    order: Float64[Tensor, "*own"],
    grad: Inexact[Tensor, "... N"],
    *,
    planar: bool,
) -> tuple[Inexact[Tensor, "*lead N"], Float64[Tensor, "*own"]]:
    """Return the gradients of values and order, given the gradient of the result.

    With G = Vᵀ grad and U = conj(λ^p) ⊙ G, they are U for the values (its real part if they are
    real) and Σ (π/2) k Im(conj(U) ⊙ values) for the order.
    """
    shape = grad.shape[1:] if planar else grad.shape
    lead, size = shape[:-1], shape[-1]
    to_values = values.new_empty(shape).view(-1, size)
    to_order = order.new_empty(len(to_values))
    grad = grad.reshape(2, -1, size) if planar else grad.reshape(-1, size)
    slope = (split.indices * (torch.pi / 2)).to(values.dtype.to_real())

    def work(piece: Piece) -> None:
        part = grad[:, piece.rows] if planar else planes(grad[piece.rows])
        c = piece.values
        g = part.new_empty(2, *c.shape)
        split.analyse(part.reshape(-1, size), g.view(-1, size))
        cosine, sine = piece.phases()  # U = (cosine - i sine)(G0 + i G1)
        real = (g[0] * cosine).addcmul_(g[1], sine)
        minus = (g[0] * sine).addcmul_(g[1], cosine, value=-1)  # -Im U
        if c.is_complex():
            torch.complex(real, -minus, out=to_values[piece.rows].view(c.shape))
            density = minus * c.real + real * c.imag
        else:
            to_values[piece.rows] = real.flatten(0, 1)
            density = minus * c
        to_order[piece.rows] = (density @ slope).flatten()

    for_each(work, pieces(values, order, lead, split.indices), spread=_spread(to_values))
    return (
        to_values.view(shape).sum_to_size(values.shape),
        to_order.view(lead).sum_to_size(order.shape),
    )
