"""Discrete tree generation (DTG): a feature grows into a binary tree of linear children."""

from typing import NamedTuple

import torch
from torch import Tensor, nn

from omnivat.model.settings import HeadSettings


class Grown(NamedTuple):
    """Nodes and how NOD looks at them."""

    nodes: Tensor  # (B, N, D), the root first
    groups: list[Tensor]  # (B, n, D) each: the root, then nodes that should point different ways


class DTG(nn.Module):
    """Discrete tree generation (DTG).

    Node 0 is the input T; in a tree, node n has the children 2n + 1 and 2n + 2, each W T + b of its
    own. R levels hold 2^R - 1 nodes. No activation, so the mean over the tree is one affine map,
    which `fold` gives.
    For comparison as many matrices can stand in series (every node the child of the one before)
    or parallel (every node a child of the root).
    Source: paper, Eq. 7 to 11, and its ablation of generation.
    """

    def __init__(
        self,
        width: int,
        *,
        levels: int = 3,
        init: str = "orthogonal",
        arrangement: str = "tree",
    ) -> None:
        super().__init__()
        self.levels = levels
        self.arrangement = arrangement
        edges = 2**levels - 2
        self.weight = nn.Parameter(torch.empty(edges, width, width))
        self.bias = nn.Parameter(torch.zeros(edges, width))
        for weight in self.weight.data:
            _initialise(weight, init)

    @classmethod
    def from_settings(cls, settings: HeadSettings) -> "DTG":
        """Build what the settings describe; without generation of its own, a root alone."""
        if not settings.edges:
            return cls(settings.width, levels=1)
        return cls(
            settings.width,
            levels=settings.levels,
            init=settings.tree_init,
            arrangement=settings.generation,
        )

    def parent(self, node: int) -> int:
        """Return the node that `node` (from 1) grows from."""
        if self.arrangement == "series":
            return node - 1
        return (node - 1) // 2 if self.arrangement == "tree" else 0

    def grow(self, root: Tensor) -> Grown:
        """Grow all nodes from root (B, D)."""
        if self.arrangement == "tree" or not len(self.weight):
            layers = self._levels(root)
            return Grown(torch.cat(layers, dim=1), layers)
        if self.arrangement == "parallel":
            children = torch.einsum("bd,ned->bne", root, self.weight) + self.bias
            return Grown(torch.cat((root[:, None], children), dim=1), [root[:, None], children])
        chain = [root]
        for weight, bias in zip(self.weight, self.bias, strict=True):
            chain.append(torch.addmm(bias, chain[-1], weight.T))
        nodes = torch.stack(chain, dim=1)
        return Grown(nodes, [root[:, None], nodes])

    def _levels(self, root: Tensor) -> list[Tensor]:
        """Grow a tree: root (B, D) -> one (B, 2^(r-1), D) for each level r, root included."""
        layers = [root[:, None]]
        sizes = [2**level for level in range(1, self.levels)]
        weights, biases = torch.split(self.weight, sizes), torch.split(self.bias, sizes)
        for weight, bias in zip(weights, biases, strict=True):
            grown = torch.einsum(
                "bnd,nked->bnke", layers[-1], weight.reshape(-1, 2, *weight.shape[1:])
            )
            layers.append(grown.flatten(1, 2) + bias)
        return layers

    def layers(self, root: Tensor) -> list[Tensor]:
        """Return the groups that NOD looks at, the root (B, 1, D) first; in a tree, its levels."""
        return self.grow(root).groups

    def nodes(self, root: Tensor) -> Tensor:
        """Return all nodes (B, 2^R - 1, D) in heap order: root, its two children, and so on."""
        return self.grow(root).nodes

    def fold(self, dtype: torch.dtype | None = None) -> tuple[Tensor, Tensor]:
        """Return M (D, D) and b (D,): the mean over all nodes of root T is T @ M.T + b, exactly.

        dtype  precision to multiply in; that of the weights where None
        """
        dtype = dtype or self.weight.dtype
        weights, biases = self.weight.to(dtype), self.bias.to(dtype)
        eye = torch.eye(weights.shape[-1], dtype=weights.dtype, device=weights.device)
        matrices, offsets = [eye], [torch.zeros_like(eye[0])]
        for node, (weight, bias) in enumerate(zip(weights, biases, strict=True), start=1):
            parent = self.parent(node)
            matrices.append(weight @ matrices[parent])
            offsets.append(weight @ offsets[parent] + bias)
        return torch.stack(matrices).mean(0), torch.stack(offsets).mean(0)


def interpolated(features: list[Tensor], levels: int) -> Tensor:
    """Return points (B, 2^R - 1, D), evenly inside the segment between VIS and TAC features.

    features  (B, D) of VIS and TAC; of one alone, every point is that one
    """
    count = 2**levels
    first, last = features[0], features[-1]
    shares = torch.arange(1, count, dtype=first.dtype, device=first.device)[:, None] / count
    return torch.lerp(first[:, None], last[:, None], shares)


def _initialise(weight: Tensor, init: str) -> None:
    """Fill one W (D, D) in place: "orthogonal" keeps node norms equal, so the tree is readable."""
    if init == "orthogonal":
        nn.init.orthogonal_(weight)
    elif init == "default":
        nn.init.kaiming_uniform_(weight, a=5**0.5)
    else:  # identity with a little noise: all nodes alike at first
        weight.copy_(torch.eye(len(weight)) + 0.01 * torch.randn_like(weight))
