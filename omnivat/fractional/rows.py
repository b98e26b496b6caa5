"""The maps between samples and eigenbasis on whole batches, a piece at a time, without a graph."""

from __future__ import annotations

import torch
from torch import Tensor

from omnivat.fractional.pieces import Piece, leading_shape, pieces, slices
from omnivat.fractional.splits import Split


def planes(x: Tensor) -> Tensor:
    """Real and imaginary part, stacked: (2, ...) for complex x, (1, ...) for real x."""
    return torch.stack([x.real, x.imag]) if x.is_complex() else x[None]


def analyse_rows(split: Split, x: Tensor) -> Tensor:
    """x V for x (..., N), real or complex."""
    rows = x.reshape(-1, x.shape[-1])
    out = rows.new_empty(rows.shape)
    for some in slices(*rows.shape, rows.device):
        if x.is_complex():
            part = planes(rows[some]).flatten(0, 1)
            found = torch.empty_like(part)
            split.analyse(part, found)
            torch.complex(*found.chunk(2), out=out[some])
        else:
            split.analyse(rows[some], out[some])
    return out.view(x.shape)


def restore_rows(split: Split, z: Tensor) -> Tensor:
    """z Vᵀ for z (..., N), real or complex."""
    rows = z.reshape(-1, z.shape[-1])
    out = rows.new_empty(rows.shape)
    for some in slices(*rows.shape, rows.device):
        if z.is_complex():
            part = planes(rows[some])
            found = torch.empty_like(part)
            split.restore(part, found)
            torch.complex(*found, out=out[some])
        else:
            split.restore(rows[some].clone(), out[some])
    return out.view(z.shape)


def turn(piece: Piece) -> Tensor:
    """Coefficients times phases as planes (2, b, N)."""
    c, real, imaginary = piece.values, piece.real, piece.imaginary
    if c.is_complex():
        return planes(c * torch.complex(real, imaginary))
    return c * torch.stack([real, imaginary])


def synthesise_rows(
    split: Split, values: Tensor, order: Tensor, *, planar: bool, out: Tensor | None = None
) -> Tensor:
    """(λ^p ⊙ values) Vᵀ: planar real (2, ..., N), else complex (..., N)."""
    size, kind = values.shape[-1], values.dtype
    shape = (*leading_shape(values, order), size)
    if planar:
        result = values.new_empty((2, *shape), dtype=kind.to_real()) if out is None else out
        flat = result.view(2, -1, size)
    else:
        result = values.new_empty(shape, dtype=kind.to_complex()) if out is None else out
        flat = result.view(-1, size)
    for piece in pieces(values, order, split.indices):
        z = turn(piece)
        if planar:
            split.restore(z, flat[:, piece.rows])
        else:
            found = torch.empty_like(z)
            split.restore(z, found)
            torch.complex(*found, out=flat[piece.rows])
    return result


def turned_back(
    split: Split, values: Tensor, order: Tensor, grad: Tensor, *, planar: bool
) -> tuple[Tensor, Tensor]:
    """Gradients in the values and in the order for the gradient of the result.

    With G = Vᵀ grad and U = conj(λ^p) ⊙ G: the values get U (its real part if they are real), the
    order gets Σ (π/2) k Im(conj(U) ⊙ values).
    """
    size, shape = values.shape[-1], (*leading_shape(values, order), values.shape[-1])
    to_values = values.new_empty(shape).view(-1, size)
    to_order = order.new_empty(len(to_values))
    grad = grad.reshape(2, -1, size) if planar else grad.reshape(-1, size)
    slope = (split.indices * (torch.pi / 2)).to(values.dtype.to_real())
    for piece in pieces(values, order, split.indices):
        part = grad[:, piece.rows] if planar else planes(grad[piece.rows])
        g = torch.empty_like(part, memory_format=torch.contiguous_format)
        split.analyse(part.reshape(-1, size), g.view(-1, size))
        real = (g[0] * piece.real).addcmul_(g[1], piece.imaginary)
        minus = (g[0] * piece.imaginary).addcmul_(g[1], piece.real, value=-1)  # -Im U
        c = piece.values
        if c.is_complex():
            torch.complex(real, -minus, out=to_values[piece.rows])
            density = minus * c.real + real * c.imag
        else:
            to_values[piece.rows] = real
            density = minus * c
        to_order[piece.rows] = density @ slope
    lead = shape[:-1]
    return (
        to_values.view(shape).sum_to_size(values.shape),
        to_order.view(lead).sum_to_size(order.shape),
    )
