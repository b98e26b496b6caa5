"""Discrete tree generation (DTG): a feature grows into a binary tree of linear children."""

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn.functional import linear

from omnivat.head.settings import HeadSettings


def parents(arrangement: str, count: int) -> list[int]:
    """Return the parent of each of `count` nodes; -1 for none.

    arrangement  "tree", "series", "parallel", or another, whose nodes have no parents

    >>> parents("tree", 7)
    [-1, 0, 0, 1, 1, 2, 2]
    """
    if arrangement == "tree":
        return [(node - 1) // 2 for node in range(count)]
    if arrangement == "series":
        return [node - 1 for node in range(count)]
    if arrangement == "parallel":
        return [-1, *([0] * (count - 1))]
    return [-1] * count


def groups(arrangement: str, count: int) -> list[range]:
    """Return the groups of nodes that NOD pushes apart: the levels of a tree.

    >>> groups("tree", 7)
    [range(0, 1), range(1, 3), range(3, 7)]
    """
    if arrangement == "tree":
        return [range(2**level - 1, 2 ** (level + 1) - 1) for level in range(count.bit_length())]
    return [range(1), range(1, count)] if arrangement == "parallel" else [range(count)]


class Grown(NamedTuple):
    """Nodes, and their groups for NOD."""

    nodes: Float[Tensor, "B N D"]  # the root first
    groups: list[Float[Tensor, "B _ D"]]  # for NOD


class DTG(nn.Module):
    """Discrete tree generation (DTG).

    Node 0 is the input T. In a tree, node n has the children 2n + 1 and 2n + 2; each child is W x +
    b of its parent x, with its own W and b. R levels have 2^R - 1 nodes. There is no activation,
    so the mean over the tree is one affine map, which `fold` returns. For comparison, the same
    number of matrices can be in series (each node is the child of the previous one) or parallel
    (each node is a child of the root). Source: paper, Eq. 8 to 11, and its ablation of generation.
    """

    def __init__(self, width: int, edges: int = 6, arrangement: str = "tree") -> None:
        super().__init__()
        self.arrangement = arrangement
        self.weight = nn.Parameter(torch.empty(edges, width, width))
        self.bias = nn.Parameter(torch.zeros(edges, width))
        for weight in self.weight.data if not self.weight.is_meta else ():  # there, a file fills it
            nn.init.orthogonal_(weight)  # node norms stay equal, so nodes are comparable

    def grow(self, root: Float[Tensor, "B D"]) -> Grown:
        """Grow all nodes in heap order: root, its two children, and so on."""
        count = len(self.weight) + 1
        rows = [root]
        edges = zip(parents(self.arrangement, count)[1:], self.weight, self.bias, strict=True)
        for parent, weight, bias in edges:
            rows.append(linear(rows[parent], weight, bias))
        nodes = torch.stack(rows, dim=1)
        sizes = [len(group) for group in groups(self.arrangement, count)]
        return Grown(nodes, list(nodes.split(sizes, dim=1)))

    def fold(self) -> tuple[Float[Tensor, "D D"], Float[Tensor, " D"]]:
        """Return M and b: the mean over all nodes of root T is T @ M.T + b.

        Products are taken in double precision.
        """
        weights, biases = self.weight.double(), self.bias.double()
        eye = torch.eye(weights.shape[-1]).to(weights)
        matrices, offsets = [eye], [torch.zeros_like(eye[0])]
        edges = zip(parents(self.arrangement, len(weights) + 1)[1:], weights, biases, strict=True)
        for parent, weight, bias in edges:
            matrices.append(weight @ matrices[parent])
            offsets.append(weight @ offsets[parent] + bias)
        means = (torch.stack(each).mean(0).to(self.weight) for each in (matrices, offsets))
        return next(means), next(means)


def grow(
    tree: DTG, settings: HeadSettings, features: Float[Tensor, "M B D"], root: Float[Tensor, "B D"]
) -> Grown | None:
    """Return all nodes of the features and their root, or None without generation."""
    if settings.generation == "none":
        return None
    if settings.generation == "interpolation":
        points = interpolated(features, settings.levels)
        return Grown(points, [root[:, None]])  # on one line: NOD does not apply
    return tree.grow(root)


def interpolated(features: Float[Tensor, "M B D"], levels: int) -> Float[Tensor, "B N D"]:
    """Return 2^R - 1 evenly spaced points between VIS and TAC; with one modality, each is its
    feature.
    """
    count = 2**levels
    first, last = features[0], features[-1]
    shares = torch.arange(1, count, dtype=first.dtype, device=first.device)[:, None] / count
    return torch.lerp(first[:, None], last[:, None], shares)
