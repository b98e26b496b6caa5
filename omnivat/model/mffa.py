"""Multimodal fractional Fourier adapter (MFFA): embeddings to embedding-frequency features."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.nn.functional import linear, normalize

from omnivat.model import factored, reference
from omnivat.model.settings import HeadSettings
from omnivat.stages import MODALITIES


class FrATT(nn.Module):
    """The weights of fractional Fourier attention (FrATT); `reference.attention` computes it.

    One head; biases on all linear layers; no output projection, residual or normalisation.
    The same weights serve VIS, TAC and LANG. The bias of the keys and the class token in the keys
    add a constant to a row of scores, which the softmax ignores.
    """

    def __init__(self, width: int, *, ffn_ratio: int = 4, scale: str = "inside") -> None:
        super().__init__()
        self.query = nn.Linear(width, width)
        self.key = nn.Linear(width, width)
        self.value = nn.Linear(width, width)
        self.ffn = nn.Sequential(nn.Linear(width, ffn_ratio * width), nn.GELU(), nn.Linear(ffn_ratio * width, width))
        root = float(width**0.5)  # √D divides the scores, or as printed the values
        self.roots = (root, 1.0) if scale == "inside" else (1.0, root)


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
        self.fratt = FrATT(settings.width, ffn_ratio=settings.ffn_ratio, scale=settings.attention_scale)
        classes = len(settings.classes)
        self.register_buffer("bank", torch.zeros(len(MODALITIES), classes, settings.width))
        self.register_buffer("bank_seen", torch.zeros(classes, dtype=torch.bool))

    def orders(self, names: Sequence[str]) -> Tensor:
        """Return the learned order: () for all modalities, or (M, 1) for each."""
        if self.order.ndim == 0:
            return self.order
        return self.order[[MODALITIES.index(name) for name in names], None]

    def parts(self, names: Sequence[str], embedding: Tensor, order: Tensor | float | None = None) -> Tensor:
        """Transform embeddings (M, B, D) to Re and Im (2, M, B, D). order None: the learned one."""
        p = self.orders(names) if order is None else torch.as_tensor(order, dtype=torch.float64)
        return reference.transform(embedding, p.to(embedding.device))  # few rows: one product with V

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
    def update_bank(self, tokens: Mapping[str, Tensor], labels: Tensor, *, momentum: float = 0.9) -> None:
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
        """Return F-bar (M, B, D) of several modalities, equal to that of `reference.mffa`.

        own     from `expand`
        guide   (B, D) F-bar of LANG: replaces token queries where guided (B,) is True
        token   (M, B, D) or (M, 1, D) class tokens; None: the class-agnostic ones
        """
        if not self.class_token:
            token = None
        elif token is None:
            token = self.class_agnostic_tokens(names)[:, None]
        if self.real == "hermitian":
            return self._complex(names, own.parts, guide, guided, token)
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

    def _complex(
        self, names: Sequence[str], parts: Tensor, guide: Tensor | None, guided: Tensor | None, token: Tensor | None
    ) -> Tensor:
        """Return F-bar by complex attention, which has no base vectors: token by token."""
        rows = [None] * len(names) if token is None else token
        return torch.stack(
            [
                self.attend(name, parts[:, m], guide=guide, guided=guided, token=rows[m])[0]
                for m, name in enumerate(names)
            ]
        )

    def attend(
        self,
        name: str,
        parts: Tensor,
        *,
        guide: Tensor | None = None,
        guided: Tensor | None = None,
        token: Tensor | None = None,
    ) -> tuple[Tensor, Tensor]:
        """Return F-bar (B, D) of one modality and its attention weights (B, Q, T), token by token.

        parts   (2, B, D) Re and Im of the transformed embedding; the rest as in `features`,
        token   (B, D) or (1, D) for this modality
        """
        tokens = reference.tokens_of(parts, self.theta[name], self.real)
        queries = reference.queries_of(tokens, guide, guided)
        if self.class_token and token is None:
            token = self.class_agnostic_token(name)
        found, weights = reference.attention(self.fratt, queries, reference.with_class_token(tokens, token))
        return self._finished(found), weights

    def _finished(self, feature: Tensor) -> Tensor:
        return normalize(feature, dim=-1) if self.unit else feature


def _theta(settings: HeadSettings) -> Tensor:
    """Return the initial θ_e (E,).

    Equal numbers have equal gradients and stay equal: E tokens would be E copies of one. "spread"
    sets them evenly from 0.5 to 1.5, which breaks the symmetry.
    """
    count = settings.expansion
    if settings.theta_init == "spread" and count > 1:
        # made on the CPU: on the device "meta", torch would import sympy for it
        return torch.linspace(0.5, 1.5, count, device="cpu").to(torch.get_default_device())
    if settings.theta_init in ("spread", "ones"):
        return torch.ones(count)
    if settings.theta_init == "signed":
        return torch.tensor([1.0, -1.0]).repeat((count + 1) // 2)[:count]
    return torch.randn(count)
