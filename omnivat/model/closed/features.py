"""F-bar of LANG, VIS and TAC for training: one autograd function with a closed-form gradient.

LANG is computed first, because it guides the others; its gradient is computed last. Each weight's
gradient is one product over the rows of all modalities. Two products and a sum would move twice the
memory.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import torch
from torch import Tensor
from torch.autograd.function import once_differentiable

from omnivat.model.closed.attention import (
    Attention,
    AttentionBack,
    Rows,
    Weights,
    attend,
    attend_back,
)
from omnivat.model.closed.turning import Turn, TurnedBack, turn_of, turned, turned_back
from omnivat.model.factored import token_table


@dataclass(frozen=True, slots=True, kw_only=True)
class Pass:
    """The other inputs of a training pass, apart from embeddings and weights."""

    length: float  # of embeddings
    unit: bool
    roots: tuple[float, float]
    channels: int  # Re and Im, or Re alone
    lang_on: Tensor  # (B,) bool
    class_mix: Tensor | None  # (B, B): class tokens as mixtures of the batch's tokens
    agnostic: Tensor | None  # (M, B, D): added to them, LANG first if present


class ClosedFeatures(NamedTuple):
    """F-bar and mean tokens, LANG first if present."""

    features: Tensor  # (M, B, D)
    tokens: Tensor  # (M, B, D), without gradient


class Stage(NamedTuple):
    """One stage, LANG or images, kept for the backward pass."""

    turn: Turn
    inner: Tensor
    attention: Attention
    tokens: Tensor  # (M, B, D) mean tokens


def closed_features(
    embedding: Tensor,
    lang: Tensor | None,
    order: Tensor,
    theta: Tensor,
    weights: Sequence[Tensor],
    given: Pass,
) -> ClosedFeatures:
    """Return F-bar of all modalities.

    embedding  (M, B, D) of VIS and TAC, of length `given.length`;  lang  (1, B, D) or None
    order      () or (M, 1) or (1, B);  theta  (M, E): LANG first if present
    weights    those of FrATT in the order of `Weights`
    """
    features, tokens = _Features.apply(given, embedding, lang, order, theta, *weights)  # type: ignore[no-untyped-call]
    return ClosedFeatures(features, tokens)


class _Features(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any,
        given: Pass,
        embedding: Tensor,
        lang: Tensor | None,
        order: Tensor,
        theta: Tensor,
        *weights: Tensor,
    ) -> tuple[Tensor, Tensor]:
        own, table = Weights(*weights), token_table(theta, given.channels)
        turn, first = turn_of(order, embedding), 0 if lang is None else 1
        stages, guide = [], None
        if lang is not None:
            stages.append(_stage(given, lang, _turn_rows(turn, slice(0, 1)), table[:1], own, 0))
            guide = given.length * stages[0].attention.feature[0]
            embedding = embedding + guide * given.lang_on[:, None]
        rest = _turn_rows(turn, slice(first, None))
        stages.append(_stage(given, embedding, rest, table[first:], own, first, guide))
        ctx.given, ctx.stages, ctx.order_shape = given, stages, order.shape
        ctx.save_for_backward(theta, *weights)
        found = torch.cat([stage.attention.feature for stage in stages])
        tokens = torch.cat([stage.tokens for stage in stages])
        ctx.mark_non_differentiable(tokens)
        return found, tokens

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: Tensor, _: Tensor) -> tuple[Tensor | None, ...]:
        theta, *tensors = ctx.saved_tensors
        given, own, stages = ctx.given, Weights(*tensors), ctx.stages
        rank = len(stages[0].attention.tokens[0])
        images, first = stages[-1], len(stages) - 1
        found, by_turn = _stage_back(given, grad[first:], images, own)
        ways, turns = [found], [by_turn]
        if first:
            assert found.guide is not None, "with LANG, images need a guide"
            on = given.lang_on[:, None]
            to_guide = found.guide + by_turn.embedding.sum(0) * on
            to_lang = torch.add(grad[:1], to_guide, alpha=given.length)
            for some in _stage_back(given, to_lang, stages[0], own):
                (ways if isinstance(some, AttentionBack) else turns).insert(0, some)  # type: ignore[arg-type]
        by_order = [some.order for some in turns]
        shared = len(ctx.order_shape) == 0 or ctx.order_shape[0] == 1  # by all modalities
        to_order = torch.stack(by_order).sum(0) if shared else torch.cat(by_order)
        to_theta = theta_back(torch.cat([way.tokens for way in ways]), theta, rank, given.channels)
        return (
            None,
            turns[-1].embedding,
            turns[0].embedding if first else None,
            to_order.reshape(ctx.order_shape),
            to_theta,
            *weight_gradients(ways),
        )


def _turn_rows(turn: Turn, rows: slice) -> Turn:
    """Return the transform of some modalities; each may have its own order."""
    return turn if len(turn.planes) == 1 else turn._replace(planes=turn.planes[rows])


def _stage(
    given: Pass,
    embedding: Tensor,
    turn: Turn,
    table: Tensor,
    weights: Weights,
    first: int,
    guide: Tensor | None = None,
) -> Stage:
    """Return F-bar and mean tokens of some modalities; `first` is the index of the first one."""
    channels, inner = turned(embedding, turn, given.channels)
    positive = torch.relu(channels)
    halves = table.shape[1] // given.channels
    base = positive if halves == 1 else torch.cat((positive, torch.relu(-channels)), dim=2)
    means = table.mean(-1)[:, None, None]  # (M, 1, 1, r)
    tokens = (means @ base).squeeze(2)
    token = None
    if given.class_mix is not None and given.agnostic is not None:
        token = given.agnostic[first : first + len(base)] + given.class_mix @ tokens
    attention = attend(
        base, table, weights, given.roots,
        token=token, guide=guide, guided=given.lang_on, unit=given.unit,
    )  # fmt: skip
    return Stage(turn, inner, attention, tokens)


def _stage_back(
    given: Pass, grad: Tensor, stage: Stage, weights: Weights
) -> tuple[AttentionBack, TurnedBack]:
    """Return the gradients of one stage, given the gradient (M, B, D) of its features."""
    saved = stage.attention
    found = attend_back(grad, saved, weights, given.roots, unit=given.unit)
    to_base = found.base
    if given.class_mix is not None:
        to_tokens = (given.class_mix.T @ found.pooled)[:, :, None]  # (M, B, 1, D)
        means = saved.tokens.mean(-1)[:, None, :, None]
        to_base = to_base.addcmul_(means, to_tokens)
        by_mean = (saved.base * to_tokens).sum((1, 3))  # (M, r)
        found.tokens.add_(by_mean[..., None], alpha=1 / found.tokens.shape[-1])
    to_base = torch.where(saved.base > 0, to_base, 0)
    if to_base.shape[2] > given.channels:
        positive, negative = to_base.split(given.channels, dim=2)
        to_base = positive - negative
    return found, turned_back(to_base, stage.inner, stage.turn)


def theta_back(grad: Tensor, theta: Tensor, rank: int, channels: int) -> Tensor:
    """Return the gradient (M, E) of θ, given that of the token table (M, r, C E)."""
    shaped = grad.view(len(grad), rank // channels, channels, channels, -1)
    by_half = shaped.diagonal(dim1=2, dim2=3).sum(-1)  # (M, h, E)
    found = by_half[:, 0] * (theta > 0)
    return found if rank == channels else found - by_half[:, 1] * (theta < 0)


def weight_gradients(ways: Sequence[AttentionBack]) -> tuple[Tensor, ...]:
    """Return the gradients of `Weights`, one product each over the rows of all modalities."""
    query = _joined([rows for way in ways for rows in way.query])
    key, value, first, second = (
        _joined([getattr(way, name) for way in ways])
        for name in ("key", "value", "first", "second")
    )
    query_bias = torch.stack([way.query_bias for way in ways]).sum(0)
    return (
        query.grads.T @ query.inputs,
        query_bias,
        key.grads.T @ key.inputs,
        value.grads.T @ value.inputs,
        value.grads.sum(0),
        first.grads.T @ first.inputs,
        first.grads.sum(0),
        second.grads.T @ second.inputs,
        second.grads.sum(0),
    )


def _joined(parts: Sequence[Rows]) -> Rows:
    if len(parts) == 1:
        return parts[0]
    return Rows(torch.cat([p.grads for p in parts]), torch.cat([p.inputs for p in parts]))
