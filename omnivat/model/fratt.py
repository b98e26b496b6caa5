"""Fractional attention (FrATT): one query set attends to expanded fractional tokens."""

from typing import NamedTuple

import torch
from torch import Tensor, nn


class Attended(NamedTuple):
    """What attention gives, and where it looked."""

    feature: Tensor  # (B, D)
    weights: Tensor  # (B, Q, T), each row sums to one


class FrATT(nn.Module):
    """Fractional Fourier attention (FrATT): attention, mean over queries, feed-forward network.

    One head; biases on all linear layers; no output projection, residual or normalisation.
    The same weights serve VIS, TAC and LANG.
    Source: paper, Eq. 4 and 6.
    """

    def __init__(self, width: int, *, ffn_ratio: int = 4, scale: str = "inside") -> None:
        super().__init__()
        self.scale = scale
        self.query = nn.Linear(width, width)
        self.key = nn.Linear(width, width)
        self.value = nn.Linear(width, width)
        self.ffn = nn.Sequential(
            nn.Linear(width, ffn_ratio * width), nn.GELU(), nn.Linear(ffn_ratio * width, width)
        )

    def forward(self, queries: Tensor, tokens: Tensor) -> Attended:
        """Attend from `queries` to `tokens`, average over the queries, feed forward.

        queries  (B, Q, D)
        tokens   (B, T, D) keys and values, with the class token already added
        return   feature (B, D) and the attention weights (B, Q, T)

        The mean over queries is taken of the weights, before the values: the same by linearity,
        and Q times cheaper.
        """
        scores = self.query(queries) @ self.key(tokens).mT
        root = queries.shape[-1] ** 0.5
        if self.scale == "inside":
            weights = torch.softmax(scores / root, dim=-1)
            mixed = weights.mean(1, keepdim=True) @ tokens
            pooled = self.value(mixed)
        else:  # as printed: the softmax is divided, so the values and not the scores shrink
            weights = torch.softmax(scores, dim=-1)
            mixed = weights.mean(1, keepdim=True) @ tokens
            pooled = self.value(mixed) / root
        return Attended(self.ffn(pooled.squeeze(1)), weights)
