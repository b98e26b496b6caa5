"""FrATT over base vectors with a closed-form gradient; `MFFA.attend` is the printed form.

A query is a token (a sum of base vectors, plus the bias) or F-bar of LANG. All query vectors are
stacked: r base vectors, the bias and the guide, A in all. A table maps queries to these vectors.

Axes here: M modalities, B pairs, r base vectors, T tokens, A query vectors, Q queries, D width.
"""

from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn.functional import gelu, linear

from omnivat.lengths import unit_rows, unit_rows_back


class Weights(NamedTuple):
    """FrATT's weights without the bias of the keys, which a softmax ignores."""

    query: Tensor
    query_bias: Tensor
    key: Tensor
    value: Tensor
    value_bias: Tensor
    first: Tensor
    first_bias: Tensor
    second: Tensor
    second_bias: Tensor


class Attention(NamedTuple):
    """The output of attention, and what the backward pass needs."""

    feature: Tensor  # (M, B, D) F-bar
    raw: Tensor  # (M B, D) before normalization
    base: Tensor  # (M, B, r, D)
    tokens: Tensor  # (M, r, T) table of tokens
    queries: Tensor  # (M, A, Q) table of queries
    guide: Tensor | None  # (B, D)
    projected: Tensor  # (M B, A, D)
    keys: Tensor  # (M B, r, D)
    scores: Tensor  # (M, B r, A)
    mixed: Tensor  # (M, B Q, r)
    attended: Tensor  # (M, B, Q, T)
    query_weight: Tensor  # (B or 1, Q, 1) weight of each query
    shares: Tensor  # (M, B, r) of base vectors
    pooled: Tensor  # (M B, D)
    values: Tensor  # (M B, D)
    hidden: Tensor  # (M B, F)
    active: Tensor  # (M B, F)


class Rows(NamedTuple):
    """A weight's gradient as a pending product: gradients of outputs, and inputs, row by row."""

    grads: Tensor
    inputs: Tensor


class AttentionBack(NamedTuple):
    """Gradients of attention; those of weights as `Rows`, for one product over all modalities."""

    base: Tensor  # (M, B, r, D)
    pooled: Tensor  # (M, B, D), also that of the class tokens
    tokens: Tensor  # (M, r, T)
    guide: Tensor | None  # (B, D)
    query_bias: Tensor
    query: list[Rows]
    key: Rows
    value: Rows
    first: Rows
    second: Rows


def query_table(tokens: Tensor, guided: bool) -> Tensor:
    """Return (M, A, Q): the queries are each token plus the bias, then the guide."""
    count, rank, queries = tokens.shape
    table = tokens.new_zeros(count, rank + 1 + guided, queries + guided)
    table[:, :rank, :queries] = tokens
    table[:, rank, :queries] = 1.0
    if guided:
        table[:, rank + 1, queries] = 1.0
    return table


def query_shares(tokens: Tensor, guided: Tensor | None) -> Tensor:
    """Return query weights (B or 1, Q): all tokens equally, or the guide where guided (B,)."""
    queries = tokens.shape[-1]
    if guided is None:
        return tokens.new_full((1, queries), 1 / queries)
    guide = guided.to(tokens.dtype)[:, None]
    return torch.cat(((1 - guide).expand(-1, queries) / queries, guide), dim=1)


def attend(
    base: Tensor,
    tokens: Tensor,
    weights: Weights,
    roots: tuple[float, float],
    *,
    token: Tensor | None,
    guide: Tensor | None = None,
    guided: Tensor | None = None,
    unit: bool = True,
) -> Attention:
    """Return F-bar (M, B, D) of base vectors (M, B, r, D); arguments as in `MFFA.features`."""
    count, batch, rank, width = base.shape
    rows, vectors = base.reshape(-1, width), base.reshape(-1, rank, width)
    score_root, value_root = roots
    keys = linear(rows, weights.key).view(-1, rank, width)
    parts = [
        linear(rows, weights.query).view(-1, rank, width),
        weights.query_bias.expand(count * batch, 1, width),
    ]
    if guide is not None:
        guide_query = linear(guide, weights.query, weights.query_bias)
        parts.append(guide_query.expand(count, batch, width).reshape(-1, 1, width))
    projected = torch.cat(parts, dim=1)
    queries = query_table(tokens, guide is not None)
    scores = torch.bmm(keys, projected.mT).view(count, batch * rank, -1)
    mixed = torch.bmm(scores, queries).view(count, batch, rank, -1)
    mixed = mixed.mT.reshape(count, -1, rank)
    full = torch.bmm(mixed, tokens) / score_root
    attended = torch.softmax(full, dim=-1).view(count, batch, -1, tokens.shape[-1])
    query_weight = query_shares(tokens, guided if guide is not None else None)[..., None]
    shares = torch.bmm((attended * query_weight).sum(2), tokens.mT)
    pooled = torch.bmm(shares.view(-1, 1, rank), vectors).view(-1, width)
    if token is not None:
        pooled = pooled + token.reshape(-1, width)
    values = linear(pooled, weights.value, weights.value_bias)
    values = values if value_root == 1 else values / value_root
    hidden = linear(values, weights.first, weights.first_bias)
    active = gelu(hidden)
    raw = linear(active, weights.second, weights.second_bias)
    feature = unit_rows(raw) if unit else raw
    return Attention(
        feature.view(count, batch, width), raw, base, tokens, queries, guide, projected, keys, scores,
        mixed, attended, query_weight, shares, pooled, values, hidden, active,
    )  # fmt: skip


def attend_back(
    grad: Tensor, saved: Attention, weights: Weights, roots: tuple[float, float], *, unit: bool
) -> AttentionBack:
    """Return all gradients, given the gradient (M, B, D) of F-bar."""
    count, batch, rank, width = saved.base.shape
    vectors = saved.base.reshape(-1, rank, width)
    score_root, value_root = roots
    to_raw = grad.reshape(-1, width)
    if unit:
        to_raw = unit_rows_back(to_raw, saved.raw)
    to_hidden = torch.ops.aten.gelu_backward(to_raw @ weights.second, saved.hidden)
    to_values = to_hidden @ weights.first
    to_values = to_values if value_root == 1 else to_values / value_root
    to_pooled = to_values @ weights.value
    # the weighted sum of base vectors
    per_row = to_pooled[:, None]
    to_shares = torch.bmm(vectors, per_row.mT).view(count, batch, rank)
    to_base = torch.bmm(saved.shares.view(-1, rank, 1), per_row)
    to_mean = torch.bmm(to_shares, saved.tokens)[:, :, None]  # (M, B, 1, T)
    to_tokens = torch.bmm(to_shares.mT, (saved.attended * saved.query_weight).sum(2))
    # the softmax
    held = saved.attended * to_mean
    to_full = torch.sub(held, saved.attended * held.sum(-1, keepdim=True))
    to_full = to_full.mul_(saved.query_weight / score_root).view(count, -1, to_tokens.shape[-1])
    # scores between tokens, then between base vectors and query vectors
    to_tokens.baddbmm_(saved.mixed.mT, to_full)
    to_mixed = torch.bmm(to_full, saved.tokens.mT).view(count, batch, -1, rank)
    to_mixed = to_mixed.mT.reshape(count, batch * rank, -1)
    to_queries = torch.bmm(saved.scores.mT, to_mixed)
    to_tokens += to_queries[:, :rank, : to_tokens.shape[-1]]
    to_scores = torch.bmm(to_mixed, saved.queries.mT).view(count * batch, rank, -1)
    to_keys = torch.bmm(to_scores, saved.projected).view(-1, width)
    to_projected = torch.bmm(to_scores.mT, saved.keys)
    to_query = to_projected[:, :rank].reshape(-1, width)
    rows = saved.base.reshape(-1, width)
    to_base = to_base.view(-1, width)
    to_base.addmm_(to_query, weights.query).addmm_(to_keys, weights.key)
    query_bias, query, to_guide = to_projected[:, rank].sum(0), [Rows(to_query, rows)], None
    if saved.guide is not None:
        to_guide_query = to_projected[:, rank + 1].view(count, batch, width).sum(0)
        query_bias, to_guide = query_bias + to_guide_query.sum(0), to_guide_query @ weights.query
        query.append(Rows(to_guide_query, saved.guide))
    return AttentionBack(
        to_base.view_as(saved.base),
        to_pooled.view(count, batch, width),
        to_tokens,
        to_guide,
        query_bias,
        query,
        Rows(to_keys, rows),
        Rows(to_values, saved.pooled),
        Rows(to_hidden, saved.values),
        Rows(to_raw, saved.active),
    )
