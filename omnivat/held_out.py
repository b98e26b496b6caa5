"""Predictions for held-out source pairs, and the calibration fitted to them.

One fold: a quarter of the source's objects is held out, and a head is trained on the rest with the
same settings. It predicts the held-out pairs as they are and under imitated sensors
(omnivat/selection.py). With plain pairs alone, a head would be as confident on a new sensor as on
its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from omnivat.calibration.fit import fit_calibration
from omnivat.data.store import Embeddings
from omnivat.evaluate import label_map, predicted_logits
from omnivat.lang.bank import LangBank
from omnivat.model.fusion import Calibration
from omnivat.model.head import OmniVaT
from omnivat.model.settings import HeadSettings
from omnivat.selection import Evidence, evidence
from omnivat.train import TrainSettings, train

FOLD = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldOut:
    """Logits by reading, and labels, of held-out pairs; `plain` marks unshifted pairs."""

    logits: dict[str, Tensor]  # (N, K) each, before any temperature
    labels: Tensor  # (N,)
    plain: Tensor  # (N,) bool


def held_out_logits(
    model: OmniVaT,
    fold: Evidence,
    *,
    modalities: Sequence[str] = ("vis", "tac"),
) -> HeldOut:
    """Return a model's logits on the held-out pairs of a fold, plain and under imitated sensors."""
    parts, labels, plain = [], [], []
    for name, pairs in fold.held.items():
        parts.append(predicted_logits(model, pairs, modalities=modalities))
        labels.append(label_map(model.settings.classes, pairs.header.classes)[pairs.label])
        plain.append(np.full(len(pairs), name == "held out"))
    return HeldOut(
        logits={name: torch.cat([part[name] for part in parts]) for name in parts[0]},
        labels=torch.from_numpy(np.concatenate(labels)),
        plain=torch.from_numpy(np.concatenate(plain)),
    )


def calibration_of(
    source: Embeddings,
    head: HeadSettings,
    settings: TrainSettings,
    *,
    bank: LangBank | None = None,
    seed: int = 0,
) -> Calibration:
    """Train once on three quarters of the source's objects and fit to the last quarter.

    Arguments as for `omnivat.train.train`.
    Raises DataError if no object can be held out.
    """
    fold = evidence(source, FOLD)
    trained = train(fold.fit, head, settings, bank=bank, seed=seed)
    found = held_out_logits(trained.model, fold, modalities=settings.given)
    return fit_calibration(found.logits, found.labels, fusion=head.fusion)
