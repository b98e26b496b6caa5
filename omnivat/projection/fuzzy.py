"""UMAP's fuzzy graph of neighbours."""

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from omnivat.projection.neighbours import Neighbours

BISECTIONS = 32


@dataclass(frozen=True, slots=True)
class Graph:
    """Undirected weighted edges over N rows: tail, head (M,) with tail != head, weight in (0, 1]."""

    tail: Tensor
    head: Tensor
    weight: Tensor
    rows: int


def fuzzy_graph(neighbours: Neighbours) -> Graph:
    """Connect each row to its neighbours with weight exp(-(d - nearest) / width), symmetrized.

    Widths are chosen so that the weights of a row add up to log2(k + 1). Weights u and v from the
    two ends of an edge give u + v - u v; each undirected edge is stored once. Source: McInnes,
    Healy and Melville, arXiv:1802.03426, section 3.1.
    """
    index, distance = neighbours.index, neighbours.distance
    rows, k = index.shape
    beyond = distance - distance[:, :1]
    weight = (-beyond / _widths(beyond, math.log2(k + 1))).exp()
    tail = torch.arange(rows, device=index.device)[:, None].expand_as(index)
    # the neighbour's weight for this row, or 0 if it does not list the row
    back = torch.where(index[index] == tail[..., None], weight[index], 0).sum(2)
    both = weight + back - weight * back
    once = (tail < index) | (back == 0)
    return Graph(tail[once], index[once], both[once], rows)


def _widths(beyond: Tensor, total: float) -> Tensor:
    """Return (N, 1) widths s with sum(exp(-beyond / s)) = total, by bisection."""
    low = torch.zeros_like(beyond[:, :1])
    high = torch.full_like(low, torch.inf)
    width = beyond.mean(1, keepdim=True).clamp_min(1e-12)
    for _ in range(BISECTIONS):
        too_wide = (-beyond / width).exp().sum(1, keepdim=True) > total
        high = torch.where(too_wide, width, high)
        low = torch.where(too_wide, low, width)
        width = torch.where(high.isinf(), 2 * width, (low + high) / 2)
    # rows with many equal distances would have width 0 or no width
    return width.clamp(1e-3 * beyond.mean().clamp_min(1e-12), 1e3 * beyond.max().clamp_min(1e-12))
