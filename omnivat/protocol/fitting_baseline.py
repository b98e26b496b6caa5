"""Fit a baseline on one source."""

from functools import partial

import numpy as np
import torch
from torch import Tensor

from omnivat.baselines import BASELINES
from omnivat.baselines.contract import Fitted
from omnivat.calibration import fit_calibration
from omnivat.data.store import Embeddings
from omnivat.evaluate import label_map
from omnivat.lang.bank import LangBank
from omnivat.protocol.choosing import Choice, Outcome, chosen_fusion, told
from omnivat.protocol.fold import fold_of, source_arrays, tensor
from omnivat.protocol.methods import Method
from omnivat.protocol.settings import Task
from omnivat.selection import Evidence
from omnivat.tables import load

SMALLEST = 1e-12  # probabilities are raised to this before a logarithm


def fit_baseline(
    method: Method,
    found: Task,
    bank: LangBank | None,
    seed: int,
    calibrate: bool,
    prior: Choice | None,
) -> Outcome:
    """Fit a baseline, which chooses its own settings on held-out objects, and its temperatures."""
    start = load(BASELINES, method.base, kind="baseline")
    fitted: Fitted = start(source_arrays(found, bank, seed))
    late, choice = is_late_fusion(fitted, found.train), prior or Choice()
    fold = fold_of(found, seed) if calibrate and prior is None else None
    if fold is not None:
        part = start(source_arrays(found, bank, seed, fold.fit))
        logits, labels = _held_logs(part, fold, found.classes)
        if late:
            logits |= {"vis_branch": logits["vis"], "tac_branch": logits["tac"]}
        fusion = chosen_fusion(logits, labels) if late else "mean"
        calibration = fit_calibration(logits, labels, fusion=fusion)
        choice = Choice(fusion=fusion, calibration=calibration)
    return Outcome(
        logits=partial(_baseline_logs, fitted),
        features=lambda pairs: fitted.features(tensor(pairs.vis), tensor(pairs.tac)),
        choice=choice,
        separate=("vis", "tac") if late else None,
        chosen=dict(fitted.chosen) | (told(choice) if late else {}),
        parameters=fitted.parameters,
    )


def is_late_fusion(fitted: Fitted, pairs: Embeddings) -> bool:
    """True when a method's prediction for both images is the mean of those for one."""
    few = pairs.select(np.arange(len(pairs)) < 8)
    found = fitted.predict(tensor(few.vis), tensor(few.tac))
    return torch.allclose(found["fused"], (found["vis"] + found["tac"]) / 2, atol=1e-6)


def _held_logs(
    fitted: Fitted, fold: Evidence, classes: tuple[str, ...]
) -> tuple[dict[str, Tensor], Tensor]:
    parts = [_baseline_logs(fitted, pairs) for pairs in fold.held.values()]
    labels = [label_map(classes, p.header.classes)[p.label] for p in fold.held.values()]
    logits = {name: torch.cat([part[name] for part in parts]) for name in parts[0]}
    return logits, torch.from_numpy(np.concatenate(labels))


def _baseline_logs(fitted: Fitted, pairs: Embeddings) -> dict[str, Tensor]:
    found = fitted.predict(tensor(pairs.vis), tensor(pairs.tac))
    return {name: values.clamp_min(SMALLEST).log() for name, values in found.items()}
