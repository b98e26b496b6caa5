"""Report of an epoch: losses, gaps, accuracies and a map, for the page."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.data.embeddings import Embeddings
from omnivat.head.head import OmniVaT
from omnivat.kit.stages import IMAGES
from omnivat.maps.projection import pca
from omnivat.maps.projection.torch_umap import aligned
from omnivat.maps.sweep import AtOrder, curve_values, facts_of, walk
from omnivat.measure.gaps.unit import unit
from omnivat.measure.predictions import label_map
from omnivat.measure.shares import counted, mean_over_domains
from omnivat.training.from_pairs.plan import TrainingPlan
from omnivat.training.watch import OnEpoch

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
        gaps = {name: value for _, name, value in curve_values(at_order, self.facts, GAPS)}
        kept = {f"{name}/{STAGE}": gaps[f"{name}/{STAGE}"] for name in GAPS}
        home = self.embeddings.header.domains.index(self.source)
        own = self.keep & (self.embeddings.domain == home)
        for reading in (one for one in ("fused", "vis", "tac") if one in at_order.probabilities):
            name = "accuracy" if reading == "fused" else f"accuracy:{reading}"
            right = at_order.probabilities[reading].argmax(1).cpu().numpy() == self.label
            if own.any():
                kept[f"{name}/source_test"] = float(right[own].mean())
            unseen = mean_over_domains(right, self.embeddings, self.source, self.keep)
            if unseen is not None:
                kept[f"{name}/unseen"] = unseen
        return {name: value for name, value in kept.items() if np.isfinite(value)}


def reporter(plan: TrainingPlan, show: Callable[[EpochReport], None], *, every: int) -> OnEpoch:
    """Return a `Watch.on_epoch` that shows a report of each epoch, with measures and a map of every
    `every`th and the last.
    """
    total = plan.training.epochs
    before: Tensor | None = None
    meter = Meter(plan.embeddings, plan.settings.classes, plan.source)

    def take(record: dict[str, float], model: OmniVaT) -> None:
        nonlocal before
        epoch, losses = int(record["epoch"]) + 1, {name: record[name] for name in LOSSES}
        report = EpochReport(epoch=epoch, total=total, losses=losses, order=record["order"])
        if epoch == total or epoch % every == 0:
            found = meter.at(model, record["order"])
            flat = pca.project(torch.cat([unit(found.features[STAGE][n]) for n in IMAGES]))
            before = flat if before is None else aligned(flat, before)
            points = np.asarray(before.double().cpu())
            report = replace(report, measures=meter.measures(found), map=points)
        show(report)

    return take
