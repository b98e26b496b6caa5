"""Multimodal fractional Fourier adapter (MFFA): embeddings to embedding-frequency features."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn.functional import linear, normalize

from omnivat.fractional import dfrft
from omnivat.modalities import MODALITIES
from omnivat.model import factored
from omnivat.model.fratt import Attended, FrATT
from omnivat.model.settings import HeadSettings


def expanded(parts: Tensor, theta: Tensor) -> Tensor:
    """Expand by θ_e and apply ReLU to each part; the results are the tokens.

    parts   (B, C, D) channels of the transformed embedding, such as its real and imaginary part
    theta   (E,) the expansion; it commutes with the linear transform
    return  (B, C E, D), E real tokens and then E imaginary ones

    The tokens are multiples of at most four vectors, so their rank is at most 4 for every E.
    Source: paper, Eq. 3, with Re and Im stacked as tokens.
    """
    tokens = torch.relu(theta[:, None] * parts[:, :, None, :])  # (B, C, E, D)
    return tokens.flatten(1, 2)


class Expanded(NamedTuple):
    """Transformed embeddings, and the base vectors of their tokens."""

    parts: Tensor  # (2, M, B, D) Re and Im
    base: Tensor  # (r, M, B, D)
    table: factored.Tables


class MFFA(nn.Module):
    """Multimodal fractional Fourier adapter (MFFA).

    Its parameters are the order p (one for all modalities or one each), θ_e for each modality,
    FrATT, and the bank of class tokens. p is float64, because rounding it to float32 changes the
    transform by 1e-5. With MFFA switched off, nothing is learned here.
    Source: paper, Eq. 3 to 6.
    """

    order: Tensor
    fratt: FrATT
    bank: Tensor
    bank_seen: Tensor
    as_printed = False  # compute token by token, like `attend`: slower, same result

    def __init__(self, settings: HeadSettings) -> None:
        super().__init__()
        self.unit = settings.feature_scale == "unit"
        self.class_token = settings.class_token
        self.real = settings.complex_to_real
        start = settings.order if settings.mffa else 0.0
        order = torch.tensor(start, dtype=torch.float64)
        if settings.order_per_modality:
            order = order.repeat(len(MODALITIES))
        self.order = nn.Parameter(order, requires_grad=settings.learn_order and settings.mffa)
        self.theta = nn.ParameterDict()
        if not settings.mffa:
            return
        for name in MODALITIES:
            self.theta[name] = nn.Parameter(_theta(settings))
        self.fratt = FrATT(
            settings.width, ffn_ratio=settings.ffn_ratio, scale=settings.attention_scale
        )
        classes = len(settings.classes)
        self.register_buffer("bank", torch.zeros(len(MODALITIES), classes, settings.width))
        self.register_buffer("bank_seen", torch.zeros(classes, dtype=torch.bool))

    @property
    def has_closed_form(self) -> bool:
        """True if `closed` has gradients for this `complex_to_real`."""
        return self.real in ("tokens", "real")

    def orders(self, names: Sequence[str]) -> Tensor:
        """Return the learned order: () for all modalities, or (M, 1) for each."""
        if self.order.ndim == 0:
            return self.order
        return self.order[[MODALITIES.index(name) for name in names], None]

    def parts(
        self, names: Sequence[str], embedding: Tensor, order: Tensor | float | None = None
    ) -> Tensor:
        """Transform embeddings (M, B, D) to Re and Im (2, M, B, D). order None: the learned one."""
        return dfrft(embedding, self.orders(names) if order is None else order, planar=True)

    def channels(self, parts: Tensor) -> Tensor:
        """Return the channels for tokens: Re and Im, their modulus, or Re. (2, ...) -> (C, ...)."""
        if self.real == "magnitude":
            modulus: Tensor = torch.linalg.vector_norm(parts, dim=0, keepdim=True)
            return modulus
        return parts[:1] if self.real == "real" else parts

    def thetas(self, names: Sequence[str]) -> Tensor:
        """Return θ_e (M, E), the factor of the channels; for the modulus, |θ_e|."""
        theta = torch.stack([self.theta[name] for name in names])
        return theta.abs() if self.real == "magnitude" else theta

    # ---- class tokens ------------------------------------------------------------------------

    def class_agnostic_tokens(self, names: Sequence[str]) -> Tensor:
        """Return the mean (M, D) over the class tokens of training; it needs no labels."""
        seen = self.bank_seen.to(self.bank.dtype)
        rows = self.bank[[MODALITIES.index(name) for name in names]]
        mean: Tensor = (seen @ rows) / seen.sum().clamp_min(1)
        return mean

    def class_agnostic_token(self, modality: str) -> Tensor:
        """Return the class-agnostic token (D,) of one modality."""
        return self.class_agnostic_tokens([modality])[0]

    @torch.no_grad()
    def update_bank(
        self, tokens: Mapping[str, Tensor], labels: Tensor, *, momentum: float = 0.9
    ) -> None:
        """Move the bank towards the class means of `tokens`, (B, D) by modality; labels (B,)."""
        if not tokens:
            return
        values = torch.stack(list(tokens.values()))  # (M, B, D)
        rows = [MODALITIES.index(name) for name in tokens]
        classes = torch.arange(len(self.bank_seen), device=labels.device)
        members = (labels == classes[:, None]).to(values.dtype)  # (K, B)
        count = members.sum(1, keepdim=True)
        means = (members @ values) / count.clamp_min(1)
        share = torch.where(self.bank_seen[:, None], 1 - momentum, 1.0) * (count > 0)
        moved = torch.lerp(self.bank[rows], means.to(self.bank.dtype), share.to(self.bank.dtype))
        self.bank[rows] = moved
        self.bank_seen |= count[:, 0] > 0

    def expand(self, names: Sequence[str], parts: Tensor) -> Expanded:
        """Return the base vectors of the tokens of parts (2, M, B, D)."""
        channels = self.channels(parts)
        table = factored.tables(self.thetas(names), len(channels))
        return Expanded(parts, factored.base_vectors(channels, table.halves.shape[1]), table)

    def mean_tokens(self, own: Expanded) -> Tensor:
        """Return the mean (M, B, D) over the tokens of each sample.

        With complex attention it is the mean of the real tokens, because class tokens are added to
        them.
        """
        if self.real == "hermitian":
            return factored.mean_channels(own.base, own.table)[0]
        return factored.combined(own.base, own.table.tokens.mean(-1)[:, None])

    # ---- attention ---------------------------------------------------------------------------

    def features(
        self,
        names: Sequence[str],
        own: Expanded,
        *,
        guide: Tensor | None = None,
        guided: Tensor | None = None,
        token: Tensor | None = None,
    ) -> Tensor:
        """Return F-bar (M, B, D) of several modalities; equal to `attend` on each.

        own     from `expand`
        guide   (B, D) F-bar of LANG: replaces token queries where guided (B,) is True
        token   (M, B, D) or (M, 1, D) class tokens; None: the class-agnostic ones
        """
        if not self.class_token:
            token = None
        elif token is None:
            token = self.class_agnostic_tokens(names)[:, None]
        if self.as_printed or self.real == "hermitian":
            return self._features_as_printed(names, own.parts, guide, guided, token)
        fratt, base, table = self.fratt, own.base, own.table
        score_root, value_root = fratt.roots
        keys = linear(base, fratt.key.weight)
        scores = factored.dots(linear(base, fratt.query.weight), keys)
        bias_scores = (keys @ fratt.query.bias).movedim(0, -1)
        weights = factored.mean_weights(scores, bias_scores, table, score_root)
        if guide is not None and guided is not None:
            guide_query = fratt.query(guide).expand(1, *keys.shape[1:])
            theirs = factored.dots(guide_query, keys).squeeze(-2) @ table.tokens
            theirs = torch.softmax(theirs / score_root, dim=-1)
            weights = torch.where(guided[:, None], theirs, weights)
        pooled = factored.mixed(base, weights, table)
        if token is not None:
            pooled = pooled + token
        return self._finished(fratt.ffn(fratt.value(pooled) / value_root))

    def _features_as_printed(
        self,
        names: Sequence[str],
        parts: Tensor,
        guide: Tensor | None,
        guided: Tensor | None,
        token: Tensor | None,
    ) -> Tensor:
        count = parts.shape[2]
        token = None if token is None else token.expand(-1, count, -1)
        return torch.stack(
            [
                self.attend(
                    name,
                    parts[:, row].movedim(0, 1),
                    guide=guide,
                    guided=guided,
                    token=None if token is None else token[row],
                ).feature
                for row, name in enumerate(names)
            ]
        )

    def attend(
        self,
        modality: str,
        parts: Tensor,
        *,
        guide: Tensor | None = None,
        guided: Tensor | None = None,
        token: Tensor | None = None,
    ) -> Attended:
        """Return F-bar of one modality and its attention weights, token by token as printed.

        parts   (B, 2, D) Re and Im of the transformed embedding
        guide, guided  as in `features`
        token   (B, D) or (D,) class token F_g; None: the class-agnostic one
        return  feature (B, D), of unit length unless feature_scale is "literal", and weights
        """
        channels = self.channels(parts.movedim(1, 0)).movedim(0, 1)
        tokens = expanded(channels, self.thetas([modality])[0])
        queries = tokens
        if guide is not None and guided is not None:
            queries = torch.where(guided[:, None, None], guide[:, None], tokens)
        if self.class_token and token is None:
            token = self.class_agnostic_token(modality)
        added = torch.zeros_like(tokens[:, :1])
        if self.class_token and token is not None:
            added = added + (token if token.ndim == 1 else token[:, None])
        if self.real != "hermitian":
            attended = self.fratt(queries, tokens + added)
        else:
            complex_queries = _halved(queries)
            if guide is not None and guided is not None:  # F-bar of LANG is real
                off = torch.zeros_like(complex_queries[:, 1:])
                imaginary = torch.where(guided[:, None, None, None], off, complex_queries[:, 1:])
                complex_queries = torch.cat((complex_queries[:, :1], imaginary), dim=1)
            complex_tokens = _halved(tokens)
            real = complex_tokens[:, :1] + added[:, None]
            attended = self.fratt.hermitian(
                complex_queries, torch.cat((real, complex_tokens[:, 1:]), dim=1)
            )
        return Attended(self._finished(attended.feature), attended.weights)

    def _finished(self, feature: Tensor) -> Tensor:
        return normalize(feature, dim=-1) if self.unit else feature


def _halved(tokens: Tensor) -> Tensor:
    """Separate real and imaginary tokens: (B, 2E, D) -> (B, 2, E, D)."""
    return tokens.reshape(len(tokens), 2, -1, tokens.shape[-1])


def _theta(settings: HeadSettings) -> Tensor:
    """Return the initial θ_e (E,).

    Equal numbers have equal gradients and stay equal: E tokens would be E copies of one. "spread"
    sets them evenly from 0.5 to 1.5, which breaks the symmetry.
    """
    count = settings.expansion
    if settings.theta_init == "spread" and count > 1:
        return torch.linspace(0.5, 1.5, count)
    if settings.theta_init in ("spread", "ones"):
        return torch.ones(count)
    if settings.theta_init == "signed":
        return torch.tensor([1.0, -1.0]).repeat((count + 1) // 2)[:count]
    return torch.randn(count)
