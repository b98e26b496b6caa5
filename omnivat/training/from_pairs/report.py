"""Report of an epoch: losses, gaps, accuracies and a map, for the page."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.data.embeddings import Embeddings
from omnivat.head.head import OmniVaT
from omnivat.maps.projection import pca
from omnivat.maps.projection.torch_umap import aligned
from omnivat.maps.sweep import AtOrder, facts_of, measured, walk
from omnivat.measure.evaluate import label_map
from omnivat.measure.gaps.unit import unit
from omnivat.measure.unseen import counted, mean_over_domains

GAPS = ("modality_gap", "domain_gap", "margin")
LOSSES = ("loss", "mma", "nod", "cross_entropy")
STAGE = "f_hat"


@dataclass(frozen=True, slots=True, kw_only=True)
class EpochReport:
    """One epoch of a training.

    epoch     counted from 1, of `total`
    losses    means over the epoch: "loss", "mma", "nod", "cross_entropy"
    order     the learned p after the epoch
    measures  "modality_gap/f_hat", "domain_gap/f_hat", "margin/f_hat" of all pairs;
              "accuracy/source_test", "accuracy/unseen" (both images; ":vis" or ":tac" for one
              modality alone) of test pairs. Empty if not measured
    map       (2N, 2) PCA of F̂, VIS rows first, aligned with the previous map; or None
    """

    epoch: int
    total: int
    losses: Mapping[str, float]
    order: float
    measures: Mapping[str, float] = field(default_factory=dict)
    map: NDArray[np.float64] | None = None


class Meter:
    """Measures one set of pairs with heads of the same classes."""

    def __init__(self, embeddings: Embeddings, classes: tuple[str, ...], source: str) -> None:
        self.embeddings, self.source = embeddings, source
        _, self.facts = facts_of(embeddings, classes)
        self.label = label_map(classes, embeddings.header.classes)[embeddings.label]
        self.keep = counted(embeddings, source) & (self.label >= 0)
        self._before: Tensor | None = None

    def at(self, model: OmniVaT, order: float) -> AtOrder:
        """Return features and predictions of all pairs at one order; keep the model's mode."""
        training = model.training
        model.eval()
        with torch.no_grad():
            found = next(
                iter(walk(model, self.embeddings, [order], stages=[STAGE], predictions=True))
            )
        model.train(training)
        return found

    def measures(self, at_order: AtOrder) -> dict[str, float]:
        """Return the measures of `EpochReport`, without undefined ones."""
        gaps = {name: value for _, name, value in measured(at_order, self.facts, GAPS)}
        kept = {f"{name}/{STAGE}": gaps[f"{name}/{STAGE}"] for name in GAPS}
        own = self.keep & (
            self.embeddings.domain == self.embeddings.header.domains.index(self.source)
        )
        for reading in (one for one in ("fused", "vis", "tac") if one in at_order.probabilities):
            name = "accuracy" if reading == "fused" else f"accuracy:{reading}"
            right = at_order.probabilities[reading].argmax(1).cpu().numpy() == self.label
            if own.any():
                kept[f"{name}/source_test"] = float(right[own].mean())
            if (
                unseen := mean_over_domains(right, self.embeddings, self.source, self.keep)
            ) is not None:
                kept[f"{name}/unseen"] = unseen
        return {name: value for name, value in kept.items() if np.isfinite(value)}

    def map(self, at_order: AtOrder) -> NDArray[Any]:
        """Return a map (2N, 2) of F̂, aligned with the previous map."""
        features = at_order.features[STAGE]
        flat = pca.project(torch.cat([unit(features["vis"]), unit(features["tac"])]))
        self._before = flat if self._before is None else aligned(flat, self._before)
        return np.asarray(self._before.double().cpu())
