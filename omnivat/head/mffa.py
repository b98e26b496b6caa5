"""Multimodal fractional Fourier adapter (MFFA): embeddings to embedding-frequency features."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Float64, Int
from torch import Tensor, nn
from torch.nn.functional import linear, normalize

from omnivat.head import factored
from omnivat.head.settings import HeadSettings
from omnivat.head.transform import transform
from omnivat.kit.stages import MODALITIES

BANK_MOMENTUM = 0.9  # of the bank of class tokens, in each batch


class FrATT(nn.Module):
    """The weights of fractional Fourier attention (FrATT), Eq. 4; `MFFA.features` computes it in
    training, `FoldedMFFA.features` in prediction.

    One head; biases on all linear layers; no output projection, residual or normalisation.
    The same weights serve VIS, TAC and LANG. The bias of the keys and the class token in the keys
    add a constant to a row of scores, which the softmax ignores.
    """

    def __init__(self, width: int, *, scale: str = "inside") -> None:
        super().__init__()
        self.query = nn.Linear(width, width)
        self.key = nn.Linear(width, width)
        self.value = nn.Linear(width, width)
        self.ffn = nn.Sequential(
            nn.Linear(width, 4 * width), nn.GELU(), nn.Linear(4 * width, width)
        )
        root = float(width**0.5)  # √D divides the scores, or as printed the values
        self.roots = (root, 1.0) if scale == "inside" else (1.0, root)


class Expanded(NamedTuple):
    """The base vectors of the tokens, and their coefficients."""

    base: Float[Tensor, "r M B D"]
    table: factored.Tables


class MFFA(nn.Module):
    """Multimodal fractional Fourier adapter (MFFA).

    Its parameters are the order p (one for all modalities or one each), θ_e for each modality,
    FrATT, and the bank of class tokens. p is float64, because rounding it to float32 changes the
    transform by 1e-5. With MFFA switched off, nothing is learned here.
    Source: paper, Eq. 3 to 6.
    """

    order: Float64[Tensor, "*any"]
    fratt: FrATT
    bank: Float[Tensor, "3 K D"]
    bank_seen: Bool[Tensor, " K"]

    def __init__(self, settings: HeadSettings) -> None:
        super().__init__()
        self.settings = settings
        order = torch.tensor(settings.order if settings.mffa else 0.0, dtype=torch.float64)
        if settings.order_per_modality:
            order = order.repeat(len(MODALITIES))
        self.order = nn.Parameter(order, requires_grad=settings.learn_order and settings.mffa)
        self.theta = nn.ParameterDict()
        if not settings.mffa:
            return
        for name in MODALITIES:
            self.theta[name] = nn.Parameter(_theta(settings))
        self.fratt = FrATT(settings.width, scale=settings.attention_scale)
        classes = len(settings.classes)
        self.register_buffer("bank", torch.zeros(len(MODALITIES), classes, settings.width))
        self.register_buffer("bank_seen", torch.zeros(classes, dtype=torch.bool))

    def orders(self, names: Sequence[str]) -> Float64[Tensor, "*any"]:
        """Return the learned order: () for all modalities, or (M, 1) for each."""
        if self.order.ndim == 0:
            return self.order
        return self.order[[MODALITIES.index(name) for name in names], None]

    def parts(
        self,
        names: Sequence[str],
        embedding: Float[Tensor, "M B D"],
        order: Tensor | float | None = None,
    ) -> Float[Tensor, "2 M B D"]:
        """Transform embeddings to Re and Im. order None: the learned one."""
        p = self.orders(names) if order is None else torch.as_tensor(order, dtype=torch.float64)
        return transform(embedding, p.to(embedding.device))  # few rows: one product with V

    def channels(self, parts: Float[Tensor, "2 *any"]) -> Float[Tensor, "#2 *any"]:
        """Return the channels for tokens: Re and Im, their modulus, or Re."""
        if self.settings.complex_to_real == "magnitude":
            modulus: Tensor = torch.linalg.vector_norm(parts, dim=0, keepdim=True)
            return modulus
        return parts[:1] if self.settings.complex_to_real == "real" else parts

    # ---- class tokens ------------------------------------------------------------------------

    def class_agnostic_tokens(self, names: Sequence[str]) -> Float[Tensor, "M D"]:
        """Return the mean over the class tokens of training; it needs no labels."""
        seen = self.bank_seen.to(self.bank.dtype)
        rows = self.bank[[MODALITIES.index(name) for name in names]]
        mean: Tensor = (seen @ rows) / seen.sum().clamp_min(1)
        return mean

    @torch.no_grad()
    def update_bank(
        self, tokens: Mapping[str, Float[Tensor, "B D"]], labels: Int[Tensor, " B"]
    ) -> None:
        """Move the bank towards the class means of `tokens`, by modality."""
        values = torch.stack(list(tokens.values()))  # (M, B, D)
        rows = [MODALITIES.index(name) for name in tokens]
        classes = torch.arange(len(self.bank_seen), device=labels.device)
        members = (labels == classes[:, None]).to(values.dtype)  # (K, B)
        count = members.sum(1, keepdim=True)
        means = (members @ values) / count.clamp_min(1)
        share = torch.where(self.bank_seen[:, None], 1 - BANK_MOMENTUM, 1.0) * (count > 0)
        self.bank[rows] = torch.lerp(self.bank[rows], means, share.to(means))
        self.bank_seen |= count[:, 0] > 0

    def expand(self, names: Sequence[str], parts: Float[Tensor, "2 M B D"]) -> Expanded:
        """Return the base vectors of the tokens. Eq. 3."""
        channels, table = self.channels(parts), self.tables(names)
        return Expanded(factored.base_vectors(channels, table.halves.shape[1]), table)

    def tables(self, names: Sequence[str]) -> factored.Tables:
        """Return the coefficients of the tokens, from θ_e; for the modulus, from |θ_e|."""
        theta = torch.stack([self.theta[name] for name in names])
        if self.settings.complex_to_real == "magnitude":
            theta = theta.abs()
        return factored.tables(theta, 2 if self.settings.complex_to_real == "tokens" else 1)

    def mean_tokens(self, expanded: Expanded) -> Float[Tensor, "M B D"]:
        """Return the mean over the tokens of each sample."""
        shares = expanded.table.tokens.mean(-1)
        return factored.combined(expanded.base, shares[:, None])

    # ---- attention ---------------------------------------------------------------------------

    def features(
        self,
        expanded: Expanded,
        *,
        guide: Float[Tensor, "B D"] | None,
        guided: Bool[Tensor, " B"],
        token: Float[Tensor, "M B D"] | None,
    ) -> Float[Tensor, "M B D"]:
        """Return F-bar of several modalities. Eq. 4 and 6.

        expanded  from `expand`
        guide     F-bar of LANG: replaces token queries where `guided` is True
        token     class tokens
        """
        fratt, (base, table) = self.fratt, expanded
        score_root, value_root = fratt.roots
        keys = linear(base, fratt.key.weight)
        scores = factored.dots(linear(base, fratt.query.weight), keys)
        bias_scores = (keys @ fratt.query.bias).movedim(0, -1)
        weights, _ = factored.attention(scores, bias_scores, table, score_root)
        if guide is not None:
            guide_query = fratt.query(guide).expand(1, *keys.shape[1:])
            theirs = factored.dots(guide_query, keys).squeeze(-2) @ table.tokens
            theirs = torch.softmax(theirs / score_root, dim=-1)
            weights = torch.where(guided[:, None], theirs, weights)
        pooled = factored.combined(base, weights @ table.tokens.mT)
        if token is not None:
            pooled = pooled + token
        return self.finished(fratt.ffn(fratt.value(pooled) / value_root))

    def finished(self, feature: Float[Tensor, "*any D"]) -> Float[Tensor, "*any D"]:
        """Return F-bar: of unit length, or as the network gives it."""
        return normalize(feature, dim=-1) if self.settings.feature_scale == "unit" else feature


def _theta(settings: HeadSettings) -> Float[Tensor, " E"]:
    """Return the initial θ_e.

    Equal numbers have equal gradients and stay equal: E tokens would be E copies of one. "spread"
    sets them evenly from 0.5 to 1.5, which breaks the symmetry.
    """
    count = settings.expansion
    if settings.theta_init == "normal":
        return torch.randn(count)
    start = torch.ones(count)
    if settings.theta_init == "signed":
        start[1::2] = -1
    if settings.theta_init == "spread" and count > 1:
        # made on the CPU: on the device "meta", torch would import sympy for it
        start = torch.linspace(0.5, 1.5, count, device="cpu").to(start)
    return start
