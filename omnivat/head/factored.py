"""FrATT over base vectors: exact for every E.

A token is ReLU(θ x) = ReLU(θ) ReLU(x) + ReLU(-θ) ReLU(-x), so the tokens of a sample are multiples
of r base vectors. For C channels (Re and Im), r = C if no θ is negative, else 2 C. The r x r scores
between base vectors determine the scores between tokens.

Axes here: r base vectors, C channels, M modalities, B pairs, D width, T = C E tokens.
"""

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

VECTOR = 16  # numbers that a processor takes at once


class Tables(NamedTuple):
    """Coefficients of tokens in base vectors; they depend on θ only."""

    # token t is the sum over s of tokens[s, t] times base vector s
    tokens: Float[Tensor, "M r T"]
    pairs: Float[Tensor, "M r*r T*T"]  # the same for pairs of tokens, query first
    columns: Float[Tensor, "M r T*T"]  # for the part of a score that depends on the key only
    halves: Float[Tensor, "M h"]  # mean over θ of ReLU(θ), and of ReLU(-θ) if any θ < 0


def base_vectors(channels: Float[Tensor, "C M B D"], halves: int) -> Float[Tensor, "r M B D"]:
    """Return ReLU(x), and ReLU(-x) if there are two halves."""
    positive = torch.relu(channels)
    return positive if halves == 1 else torch.cat((positive, torch.relu(-channels)))


def tables(theta: Float[Tensor, "M E"], channels: int) -> Tables:
    """Return the tables for θ. Without negative θ, they need half the work."""
    signs = (theta, -theta) if bool((theta < 0).any()) else (theta,)
    weights = torch.relu(torch.stack(signs, dim=1))  # (M, h, E)
    eye = torch.eye(channels, dtype=weights.dtype, device=weights.device)
    tokens = torch.einsum("mhe,cd->mhcde", weights, eye).flatten(3).flatten(1, 2)  # (M, r, T)
    pairs = torch.einsum("mri,msj->mrsij", tokens, tokens)
    columns = tokens[:, :, None].expand(-1, -1, tokens.shape[-1], -1)
    return Tables(tokens, pairs.flatten(3).flatten(1, 2), columns.flatten(2), weights.mean(-1))


def dots(
    queries: Float[Tensor, "q M B D"], keys: Float[Tensor, "r M B D"]
) -> Float[Tensor, "M B q r"]:
    """Return all dot products within a sample."""
    return torch.einsum("qmbd,rmbd->mbqr", queries, keys)


def attention(
    scores: Float[Tensor, "M B r r"], key_scores: Float[Tensor, "M B r"], table: Tables, root: float
) -> tuple[Float[Tensor, "M B T"], Float[Tensor, "M B T T"]]:
    """Return the mean of attention over a sample's own tokens as queries, and that of each.

    Without gradients, short rows are taken side by side: 6 times as fast, and within 1e-7. A
    training keeps its order of rounding, so that records repeat.

    scores      between base vectors
    key_scores  of base vectors as keys with the bias of the queries
    root        divisor of the scores
    """
    count = table.tokens.shape[-1]
    full = scores.flatten(2) @ table.pairs + key_scores @ table.columns  # (M, B, T * T)
    full = full.reshape(*full.shape[:-1], count, count) / root
    if count < VECTOR and not full.requires_grad:  # torch takes short rows number by number
        beside = torch.softmax(full.movedim(-1, 0).contiguous(), dim=0)
        return beside.mean(-1).movedim(0, -1), beside.movedim(0, -1)
    weights = torch.softmax(full, dim=-1)
    return weights.mean(-2), weights


def combined(
    base: Float[Tensor, "r M B D"],
    shares: Float[Tensor, "M #B r"],  # noqa: F821
) -> Float[Tensor, "M B D"]:
    """Return the weighted sum of base vectors."""
    first, *others = zip(base.unbind(0), torch.split(shares, 1, dim=-1), strict=True)
    total: Tensor = first[0] * first[1]
    for vector, share in others:
        total = torch.addcmul(total, vector, share)
    return total


def mean_channels(base: Float[Tensor, "r M B D"], table: Tables) -> Float[Tensor, "C M B D"]:
    """Return F, the mean over θ of the tokens of each channel."""
    halves = table.halves.T[:, None, :, None, None]
    mean: Tensor = (base.unflatten(0, (len(halves), -1)) * halves).sum(0)
    return mean
