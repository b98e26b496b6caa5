"""Facts about a head's tree nodes: lengths, predictions, and the cosines of each level."""

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import normalize, one_hot

from omnivat.data.store import Embeddings
from omnivat.head.checkpoint import Head
from omnivat.head.dtg import groups, parents
from omnivat.head.head import OmniVaT
from omnivat.kit.errors import DataError
from omnivat.kit.progress import checkpoint
from omnivat.maps.sweep.walk import coefficients_of

CHUNK = 512  # pairs with nodes in memory at once


@dataclass(frozen=True, slots=True, kw_only=True)
class TreeFacts:
    """The N nodes of a head's tree, means over B pairs."""

    parents: list[int]  # -1 for none
    lengths: Tensor  # (N,)
    probabilities: Tensor  # (N, K)
    levels: list[tuple[range, Tensor]]  # a group for NOD, and its cosines (n, n), mean over pairs


@torch.no_grad()
def tree_facts(model: OmniVaT, nodes: Tensor) -> TreeFacts:
    """Return facts about the nodes of B pairs, (B, N, D) of `model(…, nodes=True)`."""
    kind = model.settings.generation
    levels = []
    for group in groups(kind, nodes.shape[1]):
        units = normalize(nodes[:, group.start : group.stop], dim=-1)
        levels.append((group, (units @ units.mT).mean(0)))
    return TreeFacts(
        parents=parents(kind, nodes.shape[1]),
        lengths=nodes.norm(dim=-1).mean(0),
        probabilities=model.classify(nodes).softmax(-1).mean(0),
        levels=levels,
    )


@torch.no_grad()
def node_votes(head: Head, embeddings: Embeddings) -> list[tuple[str, float]]:
    """Return each node's most frequent class over a set, at the learned p, and its share of pairs.

    A node with a share near 1 gives the same class for almost every pair.
    Raises DataError if the head has no nodes or does not fit the embeddings.
    """
    head.require_embeddings(embeddings)
    kept = coefficients_of(head.model, embeddings)
    classes, counts = head.settings.classes, torch.zeros(())
    for start in range(0, len(kept), CHUNK):
        checkpoint()
        nodes = head.model.from_coefficients(kept[start : start + CHUNK], nodes=True).nodes
        if nodes is None:
            raise DataError("This head generates no nodes: it was trained without DTG.")
        # (N, K)
        counts = counts + one_hot(head.model.classify(nodes).argmax(-1), len(classes)).sum(0)
    return [
        (classes[best], int(count) / len(kept))
        for count, best in zip(*(values.tolist() for values in counts.max(dim=1)), strict=True)
    ]
