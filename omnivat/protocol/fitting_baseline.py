"""Fit a baseline on one source."""

from collections.abc import Iterable
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
from omnivat.protocol.choosing import Choice, Outcome, choice_record, chosen_fusion
from omnivat.protocol.fold import fold_of, source_arrays
from omnivat.protocol.images import inputs, require_own_images
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
    """Fit a baseline, with settings chosen on held-out objects, and its temperatures."""
    start = load(BASELINES, method.base, kind="baseline")
    fitted: Fitted = start(source_arrays(found, bank, seed))
    if fitted.images is not None:
        for pairs in (found.train, found.source_test, *found.targets.values()):
            require_own_images(pairs)
    late, choice = is_late_fusion(fitted, found.train), prior or Choice()
    # Temperatures also use imitated sensors, which shift embeddings, not images.
    wanted = calibrate and prior is None and fitted.images is None
    fold = fold_of(found, seed) if wanted else None
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
        features=lambda pairs: _joined(fitted.features(*given) for given in inputs(fitted, pairs)),
        choice=choice,
        separate=("vis", "tac") if late else None,
        chosen=dict(fitted.chosen) | (choice_record(choice) if late else {}),
        parameters=fitted.parameters,
    )


def is_late_fusion(fitted: Fitted, pairs: Embeddings) -> bool:
    """True if a method's prediction from both images is the mean of its single readings."""
    few = pairs.select(np.arange(len(pairs)) < 8)
    found = _joined(fitted.predict(*given) for given in inputs(fitted, few))
    return torch.allclose(found["fused"], (found["vis"] + found["tac"]) / 2, atol=1e-6)


def _held_logs(
    fitted: Fitted, fold: Evidence, classes: tuple[str, ...]
) -> tuple[dict[str, Tensor], Tensor]:
    parts = [_baseline_logs(fitted, pairs) for pairs in fold.held.values()]
    labels = [label_map(classes, p.header.classes)[p.label] for p in fold.held.values()]
    logits = {name: torch.cat([part[name] for part in parts]) for name in parts[0]}
    return logits, torch.from_numpy(np.concatenate(labels))


def _baseline_logs(fitted: Fitted, pairs: Embeddings) -> dict[str, Tensor]:
    found = _joined(fitted.predict(*given) for given in inputs(fitted, pairs))
    return {name: values.clamp_min(SMALLEST).log() for name, values in found.items()}


def _joined(parts: Iterable[dict[str, Tensor]]) -> dict[str, Tensor]:
    """Concatenate the parts of each array."""
    found = list(parts)
    return {name: torch.cat([part[name] for part in found]) for name in found[0]}
