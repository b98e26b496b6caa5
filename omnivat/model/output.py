"""What the head answers: predictions and every stage on the way to them."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadOutput:
    """Predictions for B pairs, and the features behind them, by modality ("vis", "tac").

    Only modalities that were given are there.
    logits     (B, K) of the cosine classifier
    frft       (B, 2, D) Re and Im of the transformed embedding
    relu       (B, 2, D) F: after θ_e and ReLU, mean over the E tokens
    f_bar      (B, D) after FrATT;  f_hat  (B, D) after DTG
    attention  (B, T, T) weights, where asked for; T = 2E tokens, or E where Re and Im are one
    nodes      (B, 2^R - 1, D) tree nodes in heap order, where asked for and there are any
    """

    logits: dict[str, Tensor]
    frft: dict[str, Tensor]
    relu: dict[str, Tensor]
    f_bar: dict[str, Tensor]
    f_hat: dict[str, Tensor]
    attention: dict[str, Tensor] = field(default_factory=dict)
    nodes: Tensor | None = None

    @property
    def modality_probabilities(self) -> dict[str, Tensor]:
        """Class probabilities (B, K) of each modality alone."""
        return {name: torch.softmax(values, dim=-1) for name, values in self.logits.items()}

    @property
    def probabilities(self) -> Tensor:
        """Fused class probabilities (B, K): the mean of the modalities' softmaxes."""
        return torch.stack(list(self.modality_probabilities.values())).mean(0)


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingOutput:
    """What the losses need from one forward pass in training."""

    features: dict[str, Tensor]  # F-bar: "vis", "tac" and "lang" where there is LANG; (B, D)
    layers: list[Tensor]  # groups (B, n, D) that NOD looks at: the tree's levels, root first
    logits: dict[str, Tensor]  # (B, K)
    tokens: dict[str, Tensor]  # mean token (B, D) of each modality, for the bank of class tokens


def joined(outputs: Sequence[HeadOutput]) -> HeadOutput:
    """Return the output of many pairs from those of chunks of them."""
    first = outputs[0]

    def cat(name: str) -> dict[str, Tensor]:
        parts = [getattr(output, name) for output in outputs]
        return {modality: torch.cat([part[modality] for part in parts]) for modality in parts[0]}

    nodes = [output.nodes for output in outputs if output.nodes is not None]
    return HeadOutput(
        logits=cat("logits"),
        frft=cat("frft"),
        relu=cat("relu"),
        f_bar=cat("f_bar"),
        f_hat=cat("f_hat"),
        attention=cat("attention") if first.attention else {},
        nodes=torch.cat(nodes) if nodes else None,
    )
