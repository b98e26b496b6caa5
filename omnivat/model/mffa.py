"""Multimodal fractional Fourier adapter (MFFA): embeddings to embedding-frequency features."""

from collections.abc import Mapping

import torch
from torch import Tensor, nn
from torch.nn.functional import normalize

from omnivat.fractional import dfrft
from omnivat.model.fratt import Attended, FrATT
from omnivat.model.settings import HeadSettings

MODALITIES = ("lang", "vis", "tac")


def planar(transformed: Tensor) -> Tensor:
    """Return real and imaginary parts side by side: complex (..., D) -> real (..., 2, D)."""
    return torch.stack((transformed.real, transformed.imag), dim=-2)


def expanded(parts: Tensor, theta: Tensor) -> Tensor:
    """Expand by θ_e, then ReLU on each part: the tokens that attention sees.

    parts   (B, 2, D) real and imaginary part of the transformed embedding
    theta   (E,) the expansion; it commutes with the transform, which is linear
    return  (B, 2E, D), E real tokens and then E imaginary ones

    The tokens are multiples of at most four vectors: the rank is 4 whatever E is.
    Source: paper, Eq. 3, with Re and Im stacked as tokens.
    """
    tokens = torch.relu(theta[:, None] * parts[:, :, None, :])  # (B, 2, E, D)
    return tokens.flatten(1, 2)


class MFFA(nn.Module):
    """Multimodal fractional Fourier adapter (MFFA).

    Holds the order p (one for all modalities, float64: rounding it to float32 moves the
    transform by 1e-5), θ_e for each modality, FrATT, and the bank of class tokens.
    Source: paper, Eq. 3 to 6.
    """

    order: Tensor
    bank: Tensor
    bank_seen: Tensor

    def __init__(self, settings: HeadSettings) -> None:
        super().__init__()
        self.unit = settings.feature_scale == "unit"
        self.class_token = settings.class_token
        order = torch.tensor(settings.order, dtype=torch.float64)
        self.order = nn.Parameter(order, requires_grad=settings.learn_order)
        self.theta = nn.ParameterDict({name: nn.Parameter(_theta(settings)) for name in MODALITIES})
        self.fratt = FrATT(
            settings.width, ffn_ratio=settings.ffn_ratio, scale=settings.attention_scale
        )
        classes = len(settings.classes)
        self.register_buffer("bank", torch.zeros(len(MODALITIES), classes, settings.width))
        self.register_buffer("bank_seen", torch.zeros(classes, dtype=torch.bool))

    def parts(self, embedding: Tensor, order: Tensor | float | None = None) -> Tensor:
        """Transform embeddings (B, D) by `order` (the learned one by default) -> (B, 2, D)."""
        return planar(dfrft(embedding, self.order if order is None else order))

    def class_agnostic_token(self, modality: str) -> Tensor:
        """Return the mean (D,) of the class tokens seen in training: labels are not needed."""
        bank = self.bank[MODALITIES.index(modality)]
        seen = self.bank_seen.to(bank.dtype)
        return (bank * seen[:, None]).sum(0) / seen.sum().clamp_min(1)

    @torch.no_grad()
    def update_bank(
        self, tokens: Mapping[str, Tensor], labels: Tensor, *, momentum: float = 0.9
    ) -> None:
        """Move the bank towards the class means of `tokens`, (B, D) by modality; labels (B,)."""
        for label in labels.unique().tolist():
            members = labels == label
            keep = momentum if self.bank_seen[label] else 0.0
            for name, values in tokens.items():
                row = self.bank[MODALITIES.index(name), label]
                row.mul_(keep).add_(values[members].mean(0), alpha=1 - keep)
            self.bank_seen[label] = True

    def attend(
        self,
        modality: str,
        parts: Tensor,
        *,
        query: Tensor | None = None,
        token: Tensor | None = None,
    ) -> Attended:
        """Return F-bar of one modality.

        parts   (B, 2, D) from `parts`
        query   (B, Q, D) what asks; the modality's own tokens where None, as without LANG
        token   (B, D) or (D,) class token F_g; the class-agnostic one where None
        return  feature (B, D), of unit length unless feature_scale is "literal", and weights
        """
        tokens = expanded(parts, self.theta[modality])
        queries = tokens if query is None else query
        if self.class_token:
            token = self.class_agnostic_token(modality) if token is None else token
            tokens = tokens + (token if token.ndim == 1 else token[:, None])
        attended = self.fratt(queries, tokens)
        feature = normalize(attended.feature, dim=-1) if self.unit else attended.feature
        return Attended(feature, attended.weights)


def _theta(settings: HeadSettings) -> Tensor:
    """Return θ_e (E,) at the start of training."""
    count = settings.expansion
    if settings.theta_init == "ones":
        return torch.ones(count)
    if settings.theta_init == "signed":
        return torch.tensor([1.0, -1.0]).repeat((count + 1) // 2)[:count]
    return torch.randn(count)
