"""V and Vᵀ as autograd functions with closed-form gradients of any order.

V is orthogonal, so V and Vᵀ are each other's gradient. `_Synthesise` fuses the phases and Vᵀ. For
higher derivatives, its gradient is that of a composition of differentiable operations.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import torch
from jaxtyping import Float64, Inexact
from torch import Tensor
from torch.autograd import Function

from omnivat.fractional.arguments import under_transform
from omnivat.fractional.batches import product_rows, synthesise_rows, turned_back
from omnivat.fractional.phases import smooth_phases
from omnivat.fractional.splits import Split, kept_numbers


def apply(
    x: Inexact[Tensor, "*lead N"], split: Split, *, back: bool = False
) -> Inexact[Tensor, "*lead N"]:
    """Return x V on the last axis, or with `back` x Vᵀ."""
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
    """Return (λ^p ⊙ values) Vᵀ on the last axis; values and order broadcast to the leading axes
    `lead`.
    """
    if torch.compiler.is_exporting() or under_transform(values, order):
        return _composed(values, order, split, planar)
    if not _wants_gradient(values, order):
        return synthesise_rows(split, values, order, lead, planar=planar)
    return _Synthesise.apply(values, order, lead, split, planar)  # type: ignore[no-any-return,no-untyped-call]


def _composed(values: Tensor, order: Tensor, split: Split, planar: bool) -> Tensor:
    """Return what `synthesise` returns, by operations that can be differentiated repeatedly."""
    phases = smooth_phases(order, split.indices).to(values.dtype.to_complex())
    whole = apply(phases * values, split, back=True)
    return torch.stack([whole.real, whole.imag]) if planar else whole


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
        return apply(grad, ctx.split, back=not ctx.back), None, None

    @staticmethod
    def jvp(ctx: Any, tangent: Tensor, *_: None) -> Tensor:
        return apply(tangent, ctx.split, back=ctx.back)

    @staticmethod
    def vmap(
        info: Any, in_dims: tuple[int, None, None], x: Tensor, split: Split, back: bool
    ) -> tuple[Tensor, int]:
        return apply(x.movedim(in_dims[0], 0), split, back=back), 0


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
        if torch.is_grad_enabled():  # create_graph=True: the gradient itself has a gradient
            composed = partial(_composed, split=ctx.split, planar=ctx.planar)
            gradients = torch.func.vjp(composed, values, order)[1](grad)
        else:
            gradients = turned_back(ctx.split, values, order, grad, planar=ctx.planar)
        return *gradients, None, None, None
