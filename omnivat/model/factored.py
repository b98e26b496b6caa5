"""FrATT over base vectors: exact for every E.

A token is ReLU(θ x) = ReLU(θ) ReLU(x) + ReLU(-θ) ReLU(-x), so the tokens of a sample are multiples
of r base vectors. For C channels (Re and Im), r = C if no θ is negative, else 2 C. The r x r scores
between base vectors determine the scores between tokens.

Axes here: r base vectors, C channels, M modalities, B pairs, D width, T = C E tokens.
"""

from typing import NamedTuple

import torch
from torch import Tensor

VECTOR = 16  # numbers that a processor takes at once


class Tables(NamedTuple):
    """Coefficients of tokens in base vectors; they depend on θ only."""

    tokens: Tensor  # (M, r, T): token t is the sum over s of tokens[s, t] times base vector s
    pairs: Tensor  # (M, r * r, T * T): the same for pairs of tokens, query first
    columns: Tensor  # (M, r, T * T): for the part of a score that depends on the key only
    halves: Tensor  # (M, h): mean over θ of ReLU(θ), and of ReLU(-θ) if any θ < 0


def base_vectors(channels: Tensor, halves: int) -> Tensor:
    """Return ReLU(x), and ReLU(-x) if there are two halves: (C, M, B, D) -> (r, M, B, D)."""
    positive = torch.relu(channels)
    return positive if halves == 1 else torch.cat((positive, torch.relu(-channels)))


def _halves(theta: Tensor) -> Tensor:
    """Return ReLU(θ), and ReLU(-θ) if any θ is negative: (M, E) -> (M, h, E)."""
    signs = (theta, -theta) if bool((theta < 0).any()) else (theta,)
    return torch.relu(torch.stack(signs, dim=1))


def _token_table(weights: Tensor, channels: int) -> Tensor:
    eye = torch.eye(channels, dtype=weights.dtype, device=weights.device)
    return torch.einsum("mhe,cd->mhcde", weights, eye).flatten(3).flatten(1, 2)


def tables(theta: Tensor, channels: int) -> Tables:
    """Return the tables for θ (M, E). If no θ is negative, they need half the work."""
    weights = _halves(theta)
    tokens = _token_table(weights, channels)
    pairs = torch.einsum("mri,msj->mrsij", tokens, tokens)
    columns = tokens[:, :, None].expand(-1, -1, tokens.shape[-1], -1)
    return Tables(tokens, pairs.flatten(3).flatten(1, 2), columns.flatten(2), weights.mean(-1))


def dots(queries: Tensor, keys: Tensor) -> Tensor:
    """Return all dot products within a sample: (q, M, B, D) and (r, M, B, D) -> (M, B, q, r)."""
    return torch.einsum("qmbd,rmbd->mbqr", queries, keys)


def mean_weights(scores: Tensor, key_scores: Tensor, table: Tables, root: float) -> Tensor:
    """Return attention (M, B, T), the mean over a sample's own tokens as queries.

    Without gradients, short rows are taken side by side: 6 times as fast, and within 1e-7. A training
    keeps its order of rounding, so that records repeat.

    scores      (M, B, r, r) between base vectors
    key_scores  (M, B, r) of base vectors as keys with the bias of the queries
    root        divisor of the scores
    """
    count = table.tokens.shape[-1]
    full = scores.flatten(2) @ table.pairs + key_scores @ table.columns  # (M, B, T * T)
    full = full.reshape(*full.shape[:-1], count, count) / root
    if count < VECTOR and not full.requires_grad:  # torch takes short rows number by number
        return torch.softmax(full.movedim(-1, 0).contiguous(), dim=0).mean(-1).movedim(0, -1)
    return torch.softmax(full, dim=-1).mean(-2)


def mixed(base: Tensor, weights: Tensor, table: Tables) -> Tensor:
    """Return the weighted sum of tokens: (r, M, B, D), (M, B, T) -> (M, B, D)."""
    return combined(base, weights @ table.tokens.mT)


def combined(base: Tensor, shares: Tensor) -> Tensor:
    """Return the weighted sum of base vectors: (r, M, B, D), (M, B or 1, r) -> (M, B, D)."""
    first, *others = zip(base.unbind(0), torch.split(shares, 1, dim=-1), strict=True)
    total: Tensor = first[0] * first[1]
    for vector, share in others:
        total = torch.addcmul(total, vector, share)
    return total


def mean_channels(base: Tensor, table: Tables) -> Tensor:
    """Return F, the mean over θ of the tokens of each channel: (r, M, B, D) -> (C, M, B, D)."""
    halves = table.halves.shape[1]
    parts = base.reshape(halves, len(base) // halves, *base.shape[1:])
    parts = parts * table.halves.T[:, None, :, None, None]
    return parts.sum(0) if halves > 1 else parts[0]
