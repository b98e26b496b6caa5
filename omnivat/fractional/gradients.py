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
from omnivat.fractional.batches import product_rows, synthesise_rows, turned_back
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
            dense = product_rows(split, eye, back=False)
        matrix = dense.mT if back else dense
        return torch.complex(x.real @ matrix, x.imag @ matrix) if x.is_complex() else x @ matrix
    if not (_wants_gradient(x) or under_transform(x)):
        return product_rows(split, x, back=back)
    return _Apply.apply(x, split, back)  # type: ignore[no-any-return,no-untyped-call]


def synthesise(
    values: Inexact[Tensor, "... N"],
    order: Float64[Tensor, "..."],
    lead: torch.Size,
    split: Split,
    planar: bool,
) -> Inexact[Tensor, "... N"]:
    """(λ^p ⊙ values) Vᵀ on the last axis; values and order broadcast to the leading axes `lead`."""
    if torch.compiler.is_exporting() or under_transform(values, order):
        phases = smooth_phases(order, split.indices).to(values.dtype.to_complex())
        whole = restore(phases * values, split)
        return torch.stack([whole.real, whole.imag]) if planar else whole
    if not _wants_gradient(values, order):
        return synthesise_rows(split, values, order, lead, planar=planar)
    return _Synthesise.apply(values, order, lead, split, planar)  # type: ignore[no-any-return,no-untyped-call]


def _wants_gradient(*tensors: Tensor) -> bool:
    return torch.is_grad_enabled() and any(tensor.requires_grad for tensor in tensors)


class _Apply(Function):
    """x V, or with `back` x Vᵀ: each is the gradient of the other."""

    @staticmethod
    def forward(x: Tensor, split: Split, back: bool) -> Tensor:
        return product_rows(split, x, back=back)

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
    def forward(
        ctx: Any, values: Tensor, order: Tensor, lead: torch.Size, split: Split, planar: bool
    ) -> Tensor:
        ctx.split, ctx.planar = split, planar
        ctx.save_for_backward(values, order)
        return synthesise_rows(split, values, order, lead, planar=planar)

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, Tensor, None, None, None]:
        values, order = ctx.saved_tensors
        # with create_graph=True, the gradient itself has a gradient
        back = _differentiable_back if torch.is_grad_enabled() else turned_back
        return *back(ctx.split, values, order, grad, planar=ctx.planar), None, None, None


def _differentiable_back(
    split: Split,
    values: Inexact[Tensor, "*lead N"],
    order: Float64[Tensor, "*own"],
    grad: Inexact[Tensor, "... N"],
    *,
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
