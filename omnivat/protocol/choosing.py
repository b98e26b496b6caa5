"""Choices made on held-out objects of a source, and the results of a fitted method."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import torch
from torch import Tensor
from torch.nn.functional import nll_loss

from omnivat.calibration import fit_calibration, fit_temperature
from omnivat.data.store import Embeddings
from omnivat.model.fusion import FUSIONS, Calibration, fused_logs

Logits = Callable[[Embeddings], dict[str, Tensor]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """Choices made on held-out objects of a source: once for each source, for all seeds.

    candidate    name of the head's settings among `Method.candidates`
    fusion       late fusion of the two modalities
    calibration  temperatures, and the share of a learned fusion
    losses       held-out log loss of each candidate
    """

    candidate: str = ""
    fusion: str = "mean"
    calibration: Calibration = field(default_factory=Calibration)
    losses: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """A fitted method, and the contents of its record.

    logits       pairs -> reading -> logits or log-probabilities (N, K) before any temperature:
                 "fused", "vis", "tac" and, of a head, "vis_branch", "tac_branch" and "pair"
    features     pairs -> "vis", "tac" and "pair" -> (N, W), the last features before classification
    choice       choices made on held-out objects
    separate     readings for late fusion; empty if the method fuses features
    """

    logits: Logits
    features: Logits
    choice: Choice
    separate: tuple[str, str] | None
    chosen: dict[str, Any] = field(default_factory=dict)
    parameters: int = 0
    guard: dict[str, float] | None = None


def choice_record(choice: Choice) -> dict[str, Any]:
    """Return a choice for the record."""
    found: dict[str, Any] = {"fusion": choice.fusion}
    if choice.losses:
        found |= {"settings": choice.candidate, "held-out log loss": dict(choice.losses)}
    return found


def chosen_fusion(logits: Mapping[str, Tensor], labels: Tensor) -> str:
    """Return the late fusion with the lowest log loss on held-out pairs, each at its own temperature.

    logits  as for `fit_calibration`; fusion needs two branches
    """
    if "vis_branch" not in logits:
        return "mean"
    share = fit_calibration(logits, labels).share

    def loss(kind: str) -> float:
        mixed = with_fused(logits, kind, share)["fused"]
        tempered_logs = torch.log_softmax(mixed / fit_temperature(mixed, labels), dim=-1)
        return round(float(nll_loss(tempered_logs, labels)), 9)

    return min((k for k in FUSIONS if k != "feature" or "pair" in logits), key=loss)


def with_fused(logits: Mapping[str, Tensor], fusion: str, share: float = 0.5) -> dict[str, Tensor]:
    """Add "fused": the fused branches, or the only modality."""
    if "vis_branch" not in logits:
        return {**logits, "fused": next(iter(logits.values()))}
    if fusion == "feature":
        return {**logits, "fused": logits["pair"]}
    branches = logits["vis_branch"], logits["tac_branch"]
    return {**logits, "fused": fused_logs(fusion, *branches, share)}
