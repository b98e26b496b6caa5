"""The head's output: class probabilities of every reading, and all stages.

A reading is a prediction from certain images:

fused       both images
vis, tac    the photo alone, the touch alone: the other image is absent
vis_branch, tac_branch  one branch inside a pair. DTG grows from T = F-bar of VIS plus F-bar of
            TAC, so a branch depends on both images and is not a single-modality reading
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import torch
from jaxtyping import Float
from torch import Tensor

from omnivat.head.fusion import Calibration, fuse, tempered

READINGS = ("fused", "vis", "tac", "vis_branch", "tac_branch")


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadOutput:
    """Predictions for B pairs, and the features behind them, by modality ("vis", "tac").

    It contains only the given modalities. T = 2E tokens, or E if Re and Im are one channel.
    """

    logits: dict[str, Float[Tensor, "B K"]]  # of the cosine classifier, for each branch
    # with the other image absent, as in a call with one image
    alone: dict[str, Float[Tensor, "B K"]]
    pair: Float[Tensor, "B K"]  # of the sum of both F-hat
    frft: dict[str, Float[Tensor, "2 B D"]]  # Re and Im of the transformed embedding
    relu: dict[str, Float[Tensor, "2 B D"]]  # F: after θ_e and ReLU, mean over the E tokens
    f_bar: dict[str, Float[Tensor, "B D"]]  # after FrATT
    f_hat: dict[str, Float[Tensor, "B D"]]  # after DTG
    attention: dict[str, Float[Tensor, "B T T"]] = field(default_factory=dict)  # if requested
    # of the tree in heap order, if requested and present
    nodes: Float[Tensor, "B N D"] | None = None
    # replace the classifier's, by reading
    taught: dict[str, Float[Tensor, "B K"]] = field(default_factory=dict)

    fusion: str = "mean"  # of the branches
    calibration: Calibration = field(default_factory=Calibration)  # on held-out source pairs

    @property
    def branch_probabilities(self) -> dict[str, Float[Tensor, "B K"]]:
        """Class probabilities of each branch; inside a pair they depend on both images."""
        temperature = self.calibration.temperature["fused"]
        if self.taught:  # its rows add up, so a branch is what one image adds
            return {name: self.taught[name].softmax(-1) for name in self.logits}
        return {name: tempered(values, temperature) for name, values in self.logits.items()}

    @property
    def alone_probabilities(self) -> dict[str, Float[Tensor, "B K"]]:
        """Class probabilities of each image with the other one absent."""
        own = self.calibration.temperature
        if self.taught:
            return {name: self.taught[name].softmax(-1) for name in self.alone}
        return {name: tempered(values, own[name]) for name, values in self.alone.items()}

    @property
    def probabilities(self) -> Float[Tensor, "B K"]:
        """Class probabilities from all given images."""
        if self.taught:
            return self.taught["fused"].softmax(-1)
        if len(self.logits) == 1:
            return next(iter(self.alone_probabilities.values()))
        return fuse(self.fusion, self.logits, self.pair, self.calibration)

    @property
    def reading_logits(self) -> dict[str, Float[Tensor, "B K"]]:
        """Logits before any temperature: "vis", "tac" and, of a pair, "vis_branch",
        "tac_branch" and "pair", the summed features.
        """
        if len(self.logits) == 1:
            return dict(self.alone)
        branches = {f"{name}_branch": values for name, values in self.logits.items()}
        return {**self.alone, **branches, "pair": self.pair}

    @property
    def readings(self) -> dict[str, Float[Tensor, "B K"]]:
        """Class probabilities by reading; branches only if both images are given."""
        found = {"fused": self.probabilities, **self.alone_probabilities}
        if len(self.logits) > 1:
            found |= {f"{name}_branch": p for name, p in self.branch_probabilities.items()}
        return found


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingOutput:
    """What the losses need from one forward pass in training."""

    features: dict[str, Float[Tensor, "B D"]]  # F-bar: "vis", "tac", and "lang" if present
    layers: list[Float[Tensor, "B _ D"]]  # groups for NOD: the tree's levels, root first
    logits: dict[str, Float[Tensor, "B K"]]
    # mean token of each modality, for the bank of class tokens
    tokens: dict[str, Float[Tensor, "B D"]]


def joined(outputs: Sequence[HeadOutput]) -> HeadOutput:
    """Concatenate the outputs of chunks of pairs."""
    first = outputs[0]

    def cat(name: str, dim: int = 0) -> dict[str, Tensor]:
        parts = [getattr(output, name) for output in outputs]
        return {one: torch.cat([part[one] for part in parts], dim=dim) for one in parts[0]}

    nodes = [output.nodes for output in outputs if output.nodes is not None]
    return HeadOutput(
        logits=cat("logits"),
        alone=cat("alone"),
        pair=torch.cat([output.pair for output in outputs]),
        fusion=first.fusion,
        calibration=first.calibration,
        frft=cat("frft", 1),
        relu=cat("relu", 1),
        f_bar=cat("f_bar"),
        f_hat=cat("f_hat"),
        attention=cat("attention") if first.attention else {},
        nodes=torch.cat(nodes) if nodes else None,
    )
