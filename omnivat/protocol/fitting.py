"""Fit one method on one source: choose its settings, fit its temperatures, train it on all pairs.

Choices and temperatures use held-out objects of the source, a quarter of each class. For one seed,
the head and the baselines hold out the same objects (`omnivat.baselines.evidence.folds`)."""

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import nll_loss

from omnivat.baselines import BASELINES
from omnivat.baselines.contract import Fitted
from omnivat.calibration import fit_calibration
from omnivat.config import settings_from
from omnivat.data.store import Embeddings
from omnivat.evaluate import label_map, predicted_logits
from omnivat.held_out import HeldOut, held_out_logits, lang_guard
from omnivat.lang.bank import LangBank
from omnivat.model.fusion import Calibration
from omnivat.model.head import OmniVaT, parameter_count
from omnivat.model.settings import HeadSettings
from omnivat.protocol.choosing import (
    Choice,
    Outcome,
    choice_record,
    chosen_fusion,
    fold_of,
    source_arrays,
    tensor,
    with_fused,
)
from omnivat.protocol.images import inputs, require_own_images
from omnivat.protocol.methods import HEAD, Method
from omnivat.protocol.settings import Task
from omnivat.selection import Evidence
from omnivat.tables import load
from omnivat.train import TrainSettings, train

SMALLEST = 1e-12  # probabilities are raised to this before a logarithm


def fit_baseline(
    method: Method, found: Task, bank: LangBank | None, seed: int, calibrate: bool, prior: Choice | None
) -> Outcome:
    """Fit a baseline, with settings chosen on held-out objects, and its temperatures."""
    begin = load(BASELINES, method.base, kind="baseline")
    choice = prior or Choice()

    def start(pairs: Embeddings | None = None) -> Fitted:
        arrays = source_arrays(found, bank, seed, pairs)
        result: Fitted = begin(replace(arrays, **method.train, settled=choice.settled))
        return result

    fitted = start()
    if fitted.images is not None:
        for pairs in (found.train, found.source_test, *found.targets.values()):
            require_own_images(pairs)
    late = is_late_fusion(fitted, found.train)
    # Temperatures also use imitated sensors, which shift embeddings, not images.
    wanted = calibrate and prior is None and fitted.images is None
    fold = fold_of(found, seed) if wanted else None
    if fold is not None:
        part = start(fold.fit)
        logits, labels = _held_logs(part, fold, found.classes)
        if late:
            logits |= {"vis_branch": logits["vis"], "tac_branch": logits["tac"]}
        fusion = chosen_fusion(logits, labels) if late else "mean"
        calibration = fit_calibration(logits, labels)
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


def _held_logs(fitted: Fitted, fold: Evidence, classes: tuple[str, ...]) -> tuple[dict[str, Tensor], Tensor]:
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


def head_settings(
    method: Method, found: Task, bank: LangBank | None, candidate: str = ""
) -> tuple[HeadSettings, TrainSettings]:
    """Return a method's settings on a task; `candidate` names one of `method.candidates`."""
    changes = method.candidates.get(candidate, {})
    training = settings_from(TrainSettings, {**method.train, **changes.get("train", {})})
    lang_width = bank.width if bank and training.lang else 1
    values = {
        "classes": found.classes,
        "input_width": found.train.width,
        "lang_width": lang_width,
        **method.head,
        **changes.get("head", {}),
    }
    return settings_from(HeadSettings, values), training


def fit_head(
    method: Method, found: Task, bank: LangBank | None, seed: int, calibrate: bool, prior: Choice | None
) -> Outcome:
    """Choose on held-out objects, then train on all pairs."""
    choice = prior or _choose_head(method, found, bank, seed, calibrate)
    head, training = head_settings(method, found, bank, choice.candidate)
    model = _trained(method, found, bank, seed, choice.candidate, found.train)
    model.calibration = choice.calibration
    both = len(method.modalities) > 1
    return Outcome(
        logits=partial(_head_logits, model, method),
        features=partial(_head_features, model, method.modalities),
        choice=choice,
        separate=("vis_branch", "tac_branch") if both else None,
        chosen={"order": model.order, **choice_record(choice)},
        parameters=parameter_count(head),
        guard=_guard(model, found, bank if training.lang and both else None, seed),
    )


def _choose_head(method: Method, found: Task, bank: LangBank | None, seed: int, calibrate: bool) -> Choice:
    """Choose the candidate with the lowest log loss on held-out pairs, as for the baselines. Then
    choose a fusion, and fit temperatures, on those pairs and under imitated sensors."""
    names, fusion = tuple(method.candidates) or ("",), stated_fusion(method)
    fold = fold_of(found, seed) if calibrate or len(names) > 1 else None
    if fold is None:
        return Choice(candidate=names[0], fusion=fusion)
    held: dict[str, HeldOut] = {}
    for name in names:
        model = _trained(method, found, bank, seed, name, fold.fit)
        held[name] = held_out_logits(model, fold, modalities=method.modalities)
    losses = {name: held_out_loss(one, fusion) for name, one in held.items()}
    best = min(losses, key=lambda name: losses[name])
    own = held[best]
    return Choice(
        candidate=best,
        fusion=chosen_fusion(own.logits, own.labels) if calibrate else fusion,
        calibration=fit_calibration(own.logits, own.labels, fusion=fusion) if calibrate else Calibration(),
        losses=losses if len(names) > 1 else {},
    )


def _trained(
    method: Method, found: Task, bank: LangBank | None, seed: int, candidate: str, pairs: Embeddings
) -> OmniVaT:
    head, training = head_settings(method, found, bank, candidate)
    used = bank.for_classes(found.classes) if bank and training.lang else None
    return train(pairs, head, training, bank=used, seed=seed).model


def held_out_loss(held: HeldOut, fusion: str) -> float:
    """Return the mean negative log-likelihood of held-out pairs, the score of the baselines."""
    fused = with_fused(held.logits, fusion)["fused"]
    logs = torch.log_softmax(fused[held.plain], dim=-1)
    return float(nll_loss(logs, held.labels[held.plain]))


def stated_fusion(method: Method) -> str:
    """Return the fusion set by a head's method, or the default."""
    return str(method.head.get("fusion", HeadSettings.__dataclass_fields__["fusion"].default))


def _head_logits(model: OmniVaT, method: Method, pairs: Embeddings) -> dict[str, Tensor]:
    logits = predicted_logits(model, pairs, modalities=method.modalities)
    return with_fused(logits, stated_fusion(method), model.calibration.share)


@torch.no_grad()
def _head_features(model: OmniVaT, modalities: tuple[str, ...], pairs: Embeddings) -> dict[str, Tensor]:
    """Return F-hat of each modality alone, and both branches concatenated as "pair"."""
    rows = {n: tensor(getattr(pairs, n)) if n in modalities else None for n in ("vis", "tac")}
    alone = {name: model(*(x if n == name else None for n, x in rows.items())).f_hat[name] for name in modalities}
    return {**alone, "pair": torch.cat(list(model(rows["vis"], rows["tac"]).f_hat.values()), -1)}


def _guard(model: OmniVaT, found: Task, bank: LangBank | None, seed: int) -> dict[str, float] | None:
    if bank is None or not len(found.source_test):
        return None
    return lang_guard(model, found.source_test, bank.for_classes(found.classes), seed=seed)


def fit(
    method: Method, found: Task, bank: LangBank | None, *, seed: int, calibrate: bool, prior: Choice | None = None
) -> Outcome:
    """Fit a method on the task's training pairs.

    calibrate  also choose the fusion and fit temperatures, with one more training for each candidate
               on three quarters of the objects
    prior      choices of another seed on this source; they are not made again
    Raises a child of OmniVatError if the method cannot run on these pairs.
    """
    fitted = fit_head if method.base == HEAD else fit_baseline
    return fitted(method, found, bank, seed, calibrate, prior)
