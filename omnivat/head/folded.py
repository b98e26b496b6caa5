"""Prediction and export with folded weights: the fast path of the head.

Scores need only θ_Qᵀ θ_K. θ_V comes after the mean over tokens, so it is merged into the first
layer of the feed-forward network. The mean of the tree is one matrix, and the class token is one
constant vector. Products of weights are computed once in double precision, so folding loses no
accuracy.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn.functional import gelu, linear

from omnivat.head import factored
from omnivat.head.mffa import MFFA


@dataclass(frozen=True, slots=True, kw_only=True)
class FoldedMFFA:
    """MFFA for given modalities with folded weights.

    Source: docs/method.md, "Folding"; `MFFA.features` is the unfolded form.
    """

    mffa: MFFA
    table: factored.Tables
    scores: Float[Tensor, "D D"]  # the score of query u and key v is u @ scores @ v
    key_scores: Float[Tensor, " D"]  # key v adds key_scores @ v to every score
    first: Float[Tensor, "H D"]  # θ_V, then the first layer
    first_bias: Float[Tensor, " H"]
    token: Float[Tensor, "M 1 D"] | None

    def features(
        self, channels: Float[Tensor, "C M B D"]
    ) -> tuple[Float[Tensor, "M B D"], Float[Tensor, "C M B D"], Float[Tensor, "M B T T"]]:
        """Return F-bar, F and attention."""
        fratt = self.mffa.fratt
        base = factored.base_vectors(channels, self.table.halves.shape[1])
        scores = factored.dots(base @ self.scores, base)
        key_scores = (base @ self.key_scores).movedim(0, -1)
        weights, each = factored.attention(scores, key_scores, self.table, fratt.roots[0])
        pooled = factored.combined(base, weights @ self.table.tokens.mT)
        if self.token is not None:
            pooled = pooled + self.token
        feature = fratt.ffn[2](gelu(linear(pooled, self.first, self.first_bias)))
        return self.mffa.finished(feature), factored.mean_channels(base, self.table), each


def fold_mffa(mffa: MFFA, names: Sequence[str]) -> FoldedMFFA:
    """Return the folded MFFA of the modalities `names`."""
    fratt, dtype = mffa.fratt, mffa.fratt.query.weight.dtype
    key, value = fratt.key.weight.double(), fratt.value.weight.double()
    wide, bias = fratt.ffn.get_parameter("0.weight").double(), fratt.ffn.get_parameter("0.bias")
    root = fratt.roots[1]
    return FoldedMFFA(
        mffa=mffa,
        table=mffa.tables(names),
        scores=(fratt.query.weight.double().T @ key).to(dtype),
        key_scores=(fratt.query.bias.double() @ key).to(dtype),
        first=(wide @ value / root).to(dtype),
        first_bias=(wide @ fratt.value.bias.double() / root + bias).to(dtype),
        token=mffa.class_agnostic_tokens(names)[:, None] if mffa.settings.class_token else None,
    )


class Folds:
    """Cache of folded weights, valid until a weight changes or gradients are wanted."""

    def __init__(self) -> None:
        self._kept: dict[tuple[str, ...], Any] = {}
        self._versions: object = None
        self._gradients = False

    def refresh(self, module: nn.Module) -> None:
        """Clear the cache if a weight has changed: in place, by loading or conversion; and if
        gradients are to reach the weights, or have.
        """
        self._gradients = torch.is_grad_enabled() and any(
            parameter.requires_grad for parameter in module.parameters()
        )
        current = [
            (tensor.data_ptr(), -1 if tensor.is_inference() else tensor._version, tensor.dtype)
            for part in module.modules()
            for tensor in (*part._parameters.values(), *part._buffers.values())
            if tensor is not None
        ]
        if self._gradients or self._versions != current:
            self._kept, self._versions = {}, None if self._gradients else current

    def get(self, name: tuple[str, ...], make: Callable[[], Any]) -> Any:
        """Return the cached value, or call `make` and cache its result."""
        if name not in self._kept:
            with torch.inference_mode(False), torch.set_grad_enabled(self._gradients):
                self._kept[name] = make()
        return self._kept[name]
