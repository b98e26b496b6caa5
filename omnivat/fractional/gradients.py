"""V and Vᵀ as autograd functions with closed-form gradients of any order.

V is orthogonal, so V and Vᵀ are each other's gradient. `Synthesise` fuses the phases and Vᵀ. For
higher derivatives, its gradient is composed of these two.
"""

from __future__ import annotations

import math
from typing import Any

import torch
from jaxtyping import Float64, Inexact
from torch import Tensor
from torch.autograd import Function

from omnivat.fractional.arguments import under_transform
from omnivat.fractional.batches import analyse_rows, restore_rows, synthesise_rows, turned_back
from omnivat.fractional.phases import smooth_phases
from omnivat.fractional.splits import Split, kept_numbers


def analyse(x: Inexact[Tensor, "*lead N"], split: Split) -> Inexact[Tensor, "*lead N"]:
    """x V on the last axis."""
    return _applied(x, split, False)


def restore(z: Inexact[Tensor, "*lead N"], split: Split) -> Inexact[Tensor, "*lead N"]:
    """z Vᵀ on the last axis."""
    return _applied(z, split, True)


def _applied(x: Inexact[Tensor, "*lead N"], split: Split, back: bool) -> Inexact[Tensor, "*lead N"]:
    """x V, or with `back` x Vᵀ."""
    if torch.compiler.is_exporting():
        with kept_numbers():  # V as numbers: an exported program has plain products, with gradients
            eye = torch.eye(x.shape[-1], dtype=x.dtype.to_real(), device=split.indices.device)
            dense = analyse_rows(split, eye)
        matrix = dense.mT if back else dense
        return torch.complex(x.real @ matrix, x.imag @ matrix) if x.is_complex() else x @ matrix
    if not _wants_gradient(x):
        return (restore_rows if back else analyse_rows)(split, x)
    return _Apply.apply(x, split, back)  # type: ignore[no-any-return,no-untyped-call]


def synthesise(
    values: Inexact[Tensor, "... N"], order: Float64[Tensor, "..."], split: Split, planar: bool
) -> Inexact[Tensor, "... N"]:
    """(λ^p ⊙ values) Vᵀ on the last axis; the order broadcasts against the leading axes."""
    if torch.compiler.is_exporting():
        phases = smooth_phases(order, split.indices).to(values.dtype.to_complex())
        found = restore(phases * values, split)
        return torch.stack([found.real, found.imag]) if planar else found
    if not _wants_gradient(values, order):
        return synthesise_rows(split, values, order, planar=planar)
    return _Synthesise.apply(values, order, split, planar)  # type: ignore[no-any-return,no-untyped-call]


def _wants_gradient(*tensors: Tensor) -> bool:
    """True if an autograd function is needed: for gradients, tangents or `torch.func`."""
    if torch.is_grad_enabled() and any(tensor.requires_grad for tensor in tensors):
        return True
    return under_transform(*tensors)


class _Apply(Function):
    """x V, or with `back` x Vᵀ: each is the gradient of the other."""

    @staticmethod
    def forward(x: Tensor, split: Split, back: bool) -> Tensor:
        return (restore_rows if back else analyse_rows)(split, x)

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: Tensor) -> None:
        _, ctx.split, ctx.back = inputs

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, None, None]:
        return _applied(grad, ctx.split, not ctx.back), None, None

    @staticmethod
    def jvp(ctx: Any, tangent: Tensor, *_: None) -> Tensor:
        return _applied(tangent, ctx.split, ctx.back)

    @staticmethod
    def vmap(
        info: Any, in_dims: tuple[int, None, None], x: Tensor, split: Split, back: bool
    ) -> tuple[Tensor, int]:
        return _applied(x.movedim(in_dims[0], 0), split, back), 0


class _Synthesise(Function):
    @staticmethod
    def forward(values: Tensor, order: Tensor, split: Split, planar: bool) -> Tensor:
        return synthesise_rows(split, values, order, planar=planar)

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: Tensor) -> None:
        values, order, ctx.split, ctx.planar = inputs
        ctx.save_for_backward(values, order)
        ctx.save_for_forward(values, order)

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, Tensor, None, None]:
        values, order = ctx.saved_tensors
        if torch.is_grad_enabled():  # create_graph=True
            found = _differentiable_back(ctx.split, values, order, grad, ctx.planar)
        else:
            found = turned_back(ctx.split, values, order, grad, planar=ctx.planar)
        return *found, None, None

    @staticmethod
    def jvp(ctx: Any, values_t: Tensor, order_t: Tensor, *_: None) -> Tensor:
        values, order = ctx.saved_tensors
        indices = ctx.split.indices
        kind = values.dtype.to_complex()
        slope = torch.complex(torch.zeros_like(indices), indices * (-math.pi / 2))
        change = values_t + (order_t[..., None] * slope).to(kind) * values
        found = restore(smooth_phases(order, indices).to(kind) * change, ctx.split)
        return torch.stack([found.real, found.imag]) if ctx.planar else found

    @staticmethod
    def vmap(
        info: Any,
        in_dims: tuple[int | None, ...],
        values: Tensor,
        order: Tensor,
        split: Split,
        planar: bool,
    ) -> tuple[Tensor, int]:
        apart, own = in_dims[0] is not None, in_dims[1] is not None
        lead = max(values.dim() - 1 - apart, order.dim() - own)
        if in_dims[0] is not None:
            values = _padded(values.movedim(in_dims[0], 0), lead + 2)
        if in_dims[1] is not None:
            order = _padded(order.movedim(in_dims[1], 0), lead + 1)
        return synthesise(values, order, split, planar), 1 if planar else 0


def _padded(batched: Tensor, axes: int) -> Tensor:
    """Insert axes of length 1 after the first, up to `axes` axes, so that the others broadcast."""
    missing = (1,) * (axes - batched.dim())
    return batched.reshape(batched.shape[0], *missing, *batched.shape[1:])


def _differentiable_back(
    split: Split,
    values: Inexact[Tensor, "*lead N"],
    order: Float64[Tensor, "*own"],
    grad: Inexact[Tensor, "... N"],
    planar: bool,
) -> tuple[Inexact[Tensor, "*lead N"], Float64[Tensor, "*own"]]:
    """The same as `batches.turned_back`, in differentiable operations."""
    grad = torch.complex(grad[0], grad[1]) if planar else grad
    back = smooth_phases(order, split.indices).to(grad.dtype).conj() * analyse(grad, split)
    to_values = back if values.is_complex() else back.real
    density = (back.conj() * values).imag * (split.indices * (math.pi / 2))
    return (
        to_values.sum_to_size(values.shape),
        density.sum(-1).to(order.dtype).sum_to_size(order.shape),
    )
