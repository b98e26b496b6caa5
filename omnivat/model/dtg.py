"""Discrete tree generation (DTG): a feature grows into a binary tree of linear children."""

import torch
from torch import Tensor, nn

from omnivat.model.settings import HeadSettings


class DTG(nn.Module):
    """Discrete tree generation (DTG).

    Node 0 is the input T; node n has the children 2n + 1 and 2n + 2, each W T + b of its own.
    R levels hold 2^R - 1 nodes. No activation, so the mean over the tree is one affine map,
    which `fold` gives.
    Source: paper, Eq. 7 to 11.
    """

    def __init__(self, width: int, *, levels: int = 3, init: str = "orthogonal") -> None:
        super().__init__()
        self.levels = levels
        edges = 2**levels - 2
        self.weight = nn.Parameter(torch.empty(edges, width, width))
        self.bias = nn.Parameter(torch.zeros(edges, width))
        for weight in self.weight.data:
            _initialise(weight, init)

    @classmethod
    def from_settings(cls, settings: HeadSettings) -> "DTG":
        """Build the tree that the settings describe."""
        return cls(settings.width, levels=settings.levels, init=settings.tree_init)

    def layers(self, root: Tensor) -> list[Tensor]:
        """Grow the tree: root (B, D) -> one (B, 2^(r-1), D) for each level r, root included."""
        layers = [root[:, None]]
        start = 0
        for level in range(1, self.levels):
            parents = 2 ** (level - 1)
            weight = self.weight[start : start + 2 * parents].unflatten(0, (parents, 2))
            bias = self.bias[start : start + 2 * parents]
            children = torch.einsum("bnd,nked->bnke", layers[-1], weight).flatten(1, 2) + bias
            layers.append(children)
            start += 2 * parents
        return layers

    def nodes(self, root: Tensor) -> Tensor:
        """Return all nodes (B, 2^R - 1, D) in heap order: root, its two children, and so on."""
        return torch.cat(self.layers(root), dim=1)

    def fold(self) -> tuple[Tensor, Tensor]:
        """Return M (D, D) and b (D,): the mean over all nodes of root T is T @ M.T + b, exactly."""
        width = self.weight.shape[-1]
        eye = torch.eye(width, dtype=self.weight.dtype, device=self.weight.device)
        matrices, offsets = [eye], [torch.zeros_like(eye[0])]
        for node, (weight, bias) in enumerate(zip(self.weight, self.bias, strict=True), start=1):
            parent = (node - 1) // 2
            matrices.append(weight @ matrices[parent])
            offsets.append(weight @ offsets[parent] + bias)
        return torch.stack(matrices).mean(0), torch.stack(offsets).mean(0)


def _initialise(weight: Tensor, init: str) -> None:
    """Fill one W (D, D) in place: "orthogonal" keeps node norms equal, so the tree is readable."""
    if init == "orthogonal":
        nn.init.orthogonal_(weight)
    elif init == "default":
        nn.init.kaiming_uniform_(weight, a=5**0.5)
    else:  # identity with a little noise: all nodes alike at first
        weight.copy_(torch.eye(len(weight)) + 0.01 * torch.randn_like(weight))
