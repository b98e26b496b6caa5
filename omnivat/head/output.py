"""The head's output: class probabilities of every reading, and all stages.

A reading is a prediction from certain images:

fused       both images
vis, tac    the photo alone, the touch alone: the other image is absent
vis_branch, tac_branch  one branch inside a pair. DTG grows from T = F-bar of VIS plus F-bar of
            TAC, so a branch depends on both images and is not a single-modality reading
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn.functional import pad

from omnivat.head.fusion import UNFITTED, Temperatures, fuse, tempered
from omnivat.kit.stages import IMAGES

READINGS = ("fused", "vis", "tac", "vis_branch", "tac_branch")


@dataclass(frozen=True, slots=True, kw_only=True)
class Lessons:
    """What labelled pairs add to a head's predictions (omnivat/head/teach.py), by teaching N."""

    known: tuple[int, ...]  # classes before each teaching
    shares: Float[Tensor, " N"]  # of the prediction before
    scores: dict[str, Float[Tensor, "B N K"]]  # linear in the embeddings, by reading

    @classmethod
    def of(
        cls,
        rows: Mapping[str, Float[Tensor, "B W"]],
        weights: Float[Tensor, "N 2 K W"],
        bias: Float[Tensor, "N K"],
        shares: Float[Tensor, " N"],
        known: tuple[int, ...],
    ) -> "Lessons":
        """Return what teaching adds, from standardised rows; one image alone counts twice."""
        parts = {
            name: torch.einsum("bw,nkw->bnk", x, weights[:, IMAGES.index(name)])
            for name, x in rows.items()
        }
        parts["fused"] = torch.stack(list(parts.values())).mean(0)
        scores = {name: 2 * part + bias for name, part in parts.items()}
        return cls(known=known, shares=shares, scores=scores)

    def __getitem__(self, pairs: Any) -> "Lessons":
        """Return what is added to some pairs: a slice, a mask or indices."""
        return replace(self, scores={name: rows[pairs] for name, rows in self.scores.items()})

    def added(self, reading: str, before: Float[Tensor, "B _"]) -> Float[Tensor, "B K"]:
        """Return class probabilities with the lessons, from those before any."""
        scores = self.scores[reading.removesuffix("_branch")]
        for time, count in enumerate((*self.known[1:], scores.shape[-1])):
            wider = pad(before, (0, count - before.shape[-1]))
            before = torch.softmax(self.shares[time] * wider + scores[:, time, :count], dim=-1)
        return before


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
    # of linear maps, which decide in place of the classifier, by reading
    maps: dict[str, Float[Tensor, "B K"]] = field(default_factory=dict)
    lessons: Lessons | None = None
    fusion: str = "mean"  # of the branches
    temperatures: Temperatures = field(default_factory=lambda: UNFITTED)

    def reading(self, name: str) -> Float[Tensor, "B K"]:
        """Return the class probabilities of one of READINGS."""
        before = self._before(name)
        return self.lessons.added(name, before) if self.lessons else before

    def _before(self, name: str) -> Float[Tensor, "B K"]:
        """Return the class probabilities before any lesson."""
        image = name.removesuffix("_branch")
        if self.maps:  # each map has one image or both: a branch is the image alone
            return self.maps[image].softmax(-1)
        known = slice(self.lessons.known[0] if self.lessons else None)  # classes
        if name == "fused" and len(self.logits) > 1:
            logits = {image: values[:, known] for image, values in self.logits.items()}
            return fuse(self.fusion, logits, self.pair[:, known], self.temperatures["fused"])
        if name == "fused":
            (name,) = self.alone
        if name in self.alone:
            return tempered(self.alone[name][:, known], self.temperatures[name])
        return tempered(self.logits[image][:, known], self.temperatures["fused"])

    @property
    def probabilities(self) -> Float[Tensor, "B K"]:
        """Class probabilities from all given images."""
        return self.reading("fused")

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
        """Class probabilities by reading: of each image with the other one absent and, if both
        are given, of each branch, which depends on both.
        """
        branches = [f"{name}_branch" for name in self.logits] if len(self.logits) > 1 else []
        return {name: self.reading(name) for name in ("fused", *self.alone, *branches)}


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingOutput:
    """What the losses need from one forward pass in training."""

    features: dict[str, Float[Tensor, "B D"]]  # F-bar: "vis", "tac", and "lang" if present
    layers: list[Float[Tensor, "B _ D"]]  # groups for NOD: the tree's levels
    logits: dict[str, Float[Tensor, "B K"]]
    # mean token of each modality, for the bank of class tokens
    tokens: dict[str, Float[Tensor, "B D"]]


def joined(outputs: Sequence[HeadOutput]) -> HeadOutput:
    """Concatenate the outputs of chunks of pairs."""
    whole: dict[str, Any] = {}
    for name in ("logits", "alone", "f_bar", "f_hat", "attention", "frft", "relu"):
        dim = 1 if name in ("frft", "relu") else 0
        parts = [getattr(output, name) for output in outputs]
        whole[name] = {key: torch.cat([part[key] for part in parts], dim) for key in parts[0]}
    nodes = [output.nodes for output in outputs if output.nodes is not None]
    pair = torch.cat([output.pair for output in outputs])
    return replace(outputs[0], pair=pair, nodes=torch.cat(nodes) if nodes else None, **whole)
