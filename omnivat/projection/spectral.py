"""Spectral initialization of the first UMAP map."""

import torch
from torch import Tensor

from omnivat.projection.fuzzy import Graph
from omnivat.seeding import derive_seed

DIRECTIONS = 4  # vectors in the iteration; two are used
STEPS, STRAIGHTEN = 30, 5  # iterations, and how often the vectors are orthogonalized
RADIUS = 10.0


def spectral_map(graph: Graph, *, seed: int = 0) -> Tensor:
    """Return a rough map (N, 2) whose largest coordinate is RADIUS.

    It approximates the first two non-constant eigenvectors of the normalised graph Laplacian by
    subspace iteration from a seeded start. Neighbours end up close together, and folds of a PCA map
    disappear. Thirty steps suffice for a start, but the eigenvectors are not converged.
    Source: Belkin and Niyogi, Neural Computation 15:1373-1396, 2003.
    """
    weight, rows = graph.weight, graph.rows
    degree = weight.new_zeros(rows).index_add_(0, graph.tail, weight)
    degree = degree.index_add_(0, graph.head, weight).clamp_min(1e-12)
    ends = torch.cat([graph.tail, graph.head])
    others = torch.cat([graph.head, graph.tail])
    step = (weight * (degree[graph.tail] * degree[graph.head]).rsqrt()).repeat(2)[:, None]

    def walked(x: Tensor) -> Tensor:
        return torch.zeros_like(x).index_add_(0, ends, step * x[others])

    constant = degree.sqrt()[:, None]
    constant = constant / constant.norm()
    generator = torch.Generator(weight.device).manual_seed(derive_seed(seed, "spectral"))
    directions = torch.randn(
        (rows, min(DIRECTIONS, rows - 1)),
        generator=generator,
        dtype=weight.dtype,
        device=weight.device,
    )
    for done in range(1, STEPS + 1):
        directions = directions + walked(directions)  # lazy walk: no negative eigenvalue
        if done % STRAIGHTEN == 0:
            directions = directions - constant @ (constant.T @ directions)
            directions = torch.linalg.qr(directions).Q
    turn = torch.linalg.eigh(directions.T @ walked(directions)).eigenvectors.flip(1)
    flat: Tensor = (directions @ turn[:, :2]) / degree.sqrt()[:, None]
    return flat * (RADIUS / flat.abs().max().clamp_min(1e-30))
