"""Fractional Fourier attention (FrATT): queries attend to expanded fractional tokens."""

from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn.functional import linear


class Attended(NamedTuple):
    """The output of attention, and its weights."""

    feature: Tensor  # (B, D)
    weights: Tensor  # (B, Q, T), each row sums to one


class FrATT(nn.Module):
    """Fractional Fourier attention (FrATT): attention, mean over queries, feed-forward network.

    One head; biases on all linear layers; no output projection, residual or normalisation.
    The same weights serve VIS, TAC and LANG. The bias of the keys and the class token in the keys
    add a constant to a row of scores, which the softmax ignores.
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

    @property
    def roots(self) -> tuple[float, float]:
        """Divisors of the scores and of the values: √D for one of them, 1 for the other."""
        root = float(self.query.in_features**0.5)
        return (root, 1.0) if self.scale == "inside" else (1.0, root)

    @property
    def closed_weights(self) -> tuple[Tensor, ...]:
        """The weights in the order of `closed.attention.Weights`."""
        first, second = self.ffn[0], self.ffn[2]
        assert isinstance(first, nn.Linear), "the network starts with a linear layer"
        assert isinstance(second, nn.Linear), "the network ends with a linear layer"
        return (
            self.query.weight,
            self.query.bias,
            self.key.weight,
            self.value.weight,
            self.value.bias,
            first.weight,
            first.bias,
            second.weight,
            second.bias,
        )

    def forward(self, queries: Tensor, tokens: Tensor) -> Attended:
        """Attend from `queries` to `tokens`, average over the queries, apply the network.

        queries  (B, Q, D)
        tokens   (B, T, D) keys and values, with the class token already added
        return   feature (B, D) and the attention weights (B, Q, T)

        The mean over queries is applied to the weights, before the values. By linearity the result
        is the same, at 1/Q of the cost.
        """
        score_root, value_root = self.roots
        scores = self.query(queries) @ self.key(tokens).mT
        weights = torch.softmax(scores / score_root, dim=-1)
        mean = weights.mean(1, keepdim=True) @ tokens
        return Attended(self.ffn((self.value(mean) / value_root).squeeze(1)), weights)

    def hermitian(self, queries: Tensor, tokens: Tensor) -> Attended:
        """Attend with complex queries and tokens: scores Re(Q Kᴴ), modulus of the mixed values.

        queries  (B, 2, Q, D) real and imaginary part;  tokens  (B, 2, T, D)
        return   feature (B, D) and the attention weights (B, Q, T)

        The weights are real and act on both parts; biases belong to the real part.
        """
        score_root, value_root = self.roots
        projected, keys = _complex_linear(self.query, queries), _complex_linear(self.key, tokens)
        weights = torch.softmax((projected @ keys.mT).sum(1) / score_root, dim=-1)
        mean = weights.mean(1, keepdim=True)[:, None] @ tokens  # (B, 2, 1, D)
        modulus = torch.linalg.vector_norm(_complex_linear(self.value, mean), dim=1)
        return Attended(self.ffn((modulus / value_root).squeeze(1)), weights)


def _complex_linear(layer: nn.Linear, parts: Tensor) -> Tensor:
    """Apply a real layer to (B, 2, N, D); its bias is added to the real part only."""
    real = layer(parts[:, :1])
    return torch.cat((real, linear(parts[:, 1:], layer.weight)), dim=1)
