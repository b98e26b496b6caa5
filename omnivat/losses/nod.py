"""Node diversity (NOD) loss: nodes of one tree level should point different ways."""

from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn.functional import normalize

EPS = 1e-12  # below this length a node has no direction


def node_cosines(nodes: Tensor) -> Tensor:
    """Return the cosine between all nodes of a level: (B, n, D) -> (B, n, n). Source: Eq. 9."""
    directions = normalize(nodes, dim=-1, eps=EPS)
    return directions @ directions.mT


def nod_loss(layers: Sequence[Tensor]) -> Tensor:
    """Node diversity (NOD): how far each level's cosines are from the identity.

    layers  one (B, 2^(r-1), D) for each level r = 1..R
    return  () >= 0: Frobenius norms summed over levels, mean over the batch

    Level 1 has one node and no cosine to reduce: it is left out, since the gradient of a norm
    at zero would be NaN. A negative cosine is punished like a positive one, as printed.
    Source: paper, Eq. 10.
    """
    total = layers[0].new_zeros(())
    for nodes in layers[1:]:
        cosines = node_cosines(nodes)
        off_diagonal = cosines - torch.diag_embed(cosines.diagonal(dim1=-2, dim2=-1))
        total = total + torch.linalg.norm(off_diagonal.flatten(1), dim=-1).mean()
    return total
