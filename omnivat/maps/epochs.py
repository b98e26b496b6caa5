"""What a training shows of its epochs: losses, gaps, accuracies and a map."""

from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.data.embeddings import Embeddings
from omnivat.head.head import OmniVaT
from omnivat.head.predict_set import label_map
from omnivat.maps.frames.builder import stacked
from omnivat.maps.projection import pca
from omnivat.maps.projection.torch_umap import aligned
from omnivat.maps.sweep import AtOrder, curve_values, facts_of, walk
from omnivat.measure.shares import counted, mean_over_domains
from omnivat.training.plan import TrainingPlan
from omnivat.training.watch import OnEpoch

GAPS = ("modality_gap", "domain_gap", "margin")
LOSSES = ("loss", "mma", "nod", "cross_entropy")
STAGE = "f_hat"
Show = Callable[[dict[str, Any], NDArray[np.float64] | None], None]


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
        """Return "modality_gap/f_hat", "domain_gap/f_hat" and "margin/f_hat" of all pairs, and
        "accuracy/source_test" and "accuracy/unseen" of test pairs (of both images; "accuracy:vis"
        or "accuracy:tac" of one alone), without undefined ones.
        """
        gaps = {name: value for _, name, value in curve_values(at_order, self.facts, GAPS)}
        kept = {f"{name}/{STAGE}": gaps[f"{name}/{STAGE}"] for name in GAPS}
        home = self.embeddings.header.domains.index(self.source)
        own = self.keep & (self.embeddings.domain == home)
        for reading in (name for name in ("fused", "vis", "tac") if name in at_order.probabilities):
            name = "accuracy" if reading == "fused" else f"accuracy:{reading}"
            right = at_order.probabilities[reading].argmax(1).cpu().numpy() == self.label
            if own.any():
                kept[f"{name}/source_test"] = float(right[own].mean())
            unseen = mean_over_domains(right, self.embeddings, self.source, self.keep)
            if unseen is not None:
                kept[f"{name}/unseen"] = unseen
        return {name: value for name, value in kept.items() if np.isfinite(value)}


def reporter(plan: TrainingPlan, show: Show, *, every: int) -> OnEpoch:
    """Return a `Watch.on_epoch` that calls `show(record, map)` after each epoch.

    record  "epoch", from 1; "order", p after it; means over it: "loss", "mma", "nod" and
            "cross_entropy"; after every `every`th epoch and the last also `Meter.measures`
    map     (2N, 2) PCA of F̂, VIS rows first, aligned with the map before it, where there are
            measures; else None
    """
    before: Tensor | None = None
    meter = Meter(plan.embeddings, plan.settings.classes, plan.source)

    def take(record: dict[str, float], model: OmniVaT) -> None:
        nonlocal before
        epoch = int(record["epoch"]) + 1
        shown = {"epoch": epoch, "order": record["order"], **{n: record[n] for n in LOSSES}}
        if epoch < plan.training.epochs and epoch % every:
            return show(shown, None)
        found = meter.at(model, record["order"])
        flat = pca.project(stacked(found.features[STAGE]))
        before = flat if before is None else aligned(flat, before)
        show(shown | meter.measures(found), np.asarray(before.double().cpu()))

    return take
