"""The maps as nodes of the graph, with their gradients in closed form; any number of times.

V is orthogonal, so each of `Analyse` and `Restore` is the other's gradient. `Synthesise` fuses
phases and `Restore`; when its own gradient must be differentiated it is written with the two.
"""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor
from torch.autograd import Function

from omnivat.fractional.phases import smooth_phases
from omnivat.fractional.rows import analyse_rows, restore_rows, synthesise_rows, turned_back
from omnivat.fractional.splits import Split


def analyse(x: Tensor, split: Split) -> Tensor:
    """x V on the last axis."""
    if not _wants_gradient(x):
        return analyse_rows(split, x)
    return _Analyse.apply(x, split)  # type: ignore[no-any-return,no-untyped-call]


def restore(z: Tensor, split: Split) -> Tensor:
    """z Vᵀ on the last axis."""
    if not _wants_gradient(z):
        return restore_rows(split, z)
    return _Restore.apply(z, split)  # type: ignore[no-any-return,no-untyped-call]


def synthesise(values: Tensor, order: Tensor, split: Split, planar: bool) -> Tensor:
    """(λ^p ⊙ values) Vᵀ on the last axis; order (...) float64 broadcasts against the leading axes."""
    if not _wants_gradient(values, order):
        return synthesise_rows(split, values, order, planar=planar)
    return _Synthesise.apply(values, order, split, planar)  # type: ignore[no-any-return,no-untyped-call]


def _wants_gradient(*tensors: Tensor) -> bool:
    return torch.is_grad_enabled() and any(tensor.requires_grad for tensor in tensors)


class _Analyse(Function):
    @staticmethod
    def forward(x: Tensor, split: Split) -> Tensor:
        return analyse_rows(split, x)

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: Tensor) -> None:
        ctx.split = inputs[1]

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, None]:
        return restore(grad, ctx.split), None


class _Restore(Function):
    @staticmethod
    def forward(z: Tensor, split: Split) -> Tensor:
        return restore_rows(split, z)

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: Tensor) -> None:
        ctx.split = inputs[1]

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, None]:
        return analyse(grad, ctx.split), None


class _Synthesise(Function):
    @staticmethod
    def forward(values: Tensor, order: Tensor, split: Split, planar: bool) -> Tensor:
        return synthesise_rows(split, values, order, planar=planar)

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: Tensor) -> None:
        values, order, ctx.split, ctx.planar = inputs
        ctx.save_for_backward(values, order)

    @staticmethod
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, Tensor, None, None]:
        values, order = ctx.saved_tensors
        if torch.is_grad_enabled():  # create_graph=True
            found = _differentiable_back(ctx.split, values, order, grad, ctx.planar)
        else:
            found = turned_back(ctx.split, values, order, grad, planar=ctx.planar)
        return *found, None, None


def _differentiable_back(
    split: Split, values: Tensor, order: Tensor, grad: Tensor, planar: bool
) -> tuple[Tensor, Tensor]:
    """`rows.turned_back` in operations that can be differentiated again."""
    grad = torch.complex(grad[0], grad[1]) if planar else grad
    back = smooth_phases(order, split.indices).to(grad.dtype).conj() * analyse(grad, split)
    to_values = back if values.is_complex() else back.real
    density = (back.conj() * values).imag * (split.indices * (math.pi / 2))
    return (
        to_values.sum_to_size(values.shape),
        density.sum(-1).to(order.dtype).sum_to_size(order.shape),
    )
