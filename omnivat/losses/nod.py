"""Node diversity (NOD) loss: it pushes the nodes of a tree level apart."""

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor
from torch.autograd.function import once_differentiable

EPS = 1e-12  # below this length a node has no direction


def nod_loss(layers: Sequence[Tensor]) -> Tensor:
    """Node diversity (NOD): the distance of each level's cosine matrix from the identity.

    layers  one (B, 2^(r-1), D) for each level r = 1..R
    return  () >= 0: Frobenius norms summed over levels, mean over the batch

    Level 1 has one node and is left out, because the gradient of a norm at zero would be NaN.
    Negative and positive cosines count equally, as printed.
    Source: paper, Eq. 9 and 10.
    """
    total = layers[0].new_zeros(())
    for nodes in layers[1:]:
        total = total + _Diversity.apply(nodes)  # type: ignore[no-untyped-call]
    return total


class _Diversity(torch.autograd.Function):
    """The term of one level, with a closed-form gradient."""

    @staticmethod
    def forward(ctx: Any, nodes: Tensor) -> Tensor:
        lengths = torch.linalg.vector_norm(nodes, dim=-1, keepdim=True).clamp_min_(EPS)
        directions = nodes / lengths
        cosines = directions @ directions.mT
        cosines.diagonal(dim1=-2, dim2=-1).zero_()
        norms = torch.linalg.vector_norm(cosines, dim=(-2, -1))
        ctx.save_for_backward(lengths, directions, cosines, norms)
        loss: Tensor = norms.mean()
        return loss

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: Tensor) -> Tensor:
        lengths, directions, cosines, norms = ctx.saved_tensors
        scale = torch.where(norms > 0, 2 * grad / (len(norms) * norms), 0)[:, None, None]
        to_directions = scale * (cosines @ directions)
        along = (to_directions * directions).sum(-1, keepdim=True) * (lengths > EPS)
        found: Tensor = torch.addcmul(to_directions, directions, along, value=-1).div_(lengths)
        return found
