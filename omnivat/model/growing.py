"""Grow nodes from a root by matrices, without copying the matrices in either direction."""

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor
from torch.autograd.function import once_differentiable


def grown_nodes(root: Tensor, weight: Tensor, bias: Tensor, parents: Sequence[int]) -> Tensor:
    """Return all nodes (B, N, D) from the root (B, D): node n is W p + b of its parent p.

    weight, bias  (N - 1, D, D) and (N - 1, D): those of node n are at index n - 1
    parents       of nodes 1, 2, …; a parent comes before its children
    """
    nodes: Tensor = _Grow.apply(root, weight, bias, tuple(parents))  # type: ignore[no-untyped-call]
    return nodes.movedim(0, 1)


class _Grow(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any, root: Tensor, weight: Tensor, bias: Tensor, parents: tuple[int, ...]
    ) -> Tensor:
        nodes = root.new_empty(len(parents) + 1, *root.shape)
        nodes[0] = root
        rows = nodes.unbind(0)
        for child, (parent, matrix, offset) in enumerate(
            zip(parents, weight.unbind(0), bias.unbind(0), strict=True), start=1
        ):
            torch.addmm(offset, rows[parent], matrix.T, out=rows[child])
        ctx.parents = parents
        ctx.save_for_backward(nodes, weight)
        return nodes

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: Tensor) -> tuple[Tensor, Tensor, Tensor, None]:
        nodes, weight = ctx.saved_tensors
        grad = grad.clone(memory_format=torch.contiguous_format)  # (N, B, D), summed into below
        to_weight = torch.empty_like(weight)
        rows, to_rows, to_matrices = nodes.unbind(0), grad.unbind(0), to_weight.unbind(0)
        matrices = weight.unbind(0)
        for child in range(len(ctx.parents), 0, -1):
            parent = ctx.parents[child - 1]
            torch.mm(to_rows[child].T, rows[parent], out=to_matrices[child - 1])
            to_rows[parent].addmm_(to_rows[child], matrices[child - 1])
        return to_rows[0], to_weight, grad[1:].sum(1), None
