"""Fit the head, or a part of it, on one source."""

from functools import partial

import torch
from torch import Tensor
from torch.nn.functional import nll_loss

from omnivat.calibration import fit_calibration
from omnivat.config import settings_from
from omnivat.data.store import Embeddings
from omnivat.evaluate import predicted_logits
from omnivat.guard import lang_guard
from omnivat.held_out import HeldOut, held_out_logits
from omnivat.lang.bank import LangBank
from omnivat.model.fusion import Calibration
from omnivat.model.head import OmniVaT, parameter_count
from omnivat.model.settings import HeadSettings
from omnivat.protocol.choosing import Choice, Outcome, choice_record, chosen_fusion, with_fused
from omnivat.protocol.fold import fold_of, tensor
from omnivat.protocol.methods import Method
from omnivat.protocol.settings import Task
from omnivat.train import TrainSettings, train


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
    method: Method,
    found: Task,
    bank: LangBank | None,
    seed: int,
    calibrate: bool,
    prior: Choice | None,
) -> Outcome:
    """Choose on held-out objects, then train on all pairs."""
    choice = prior or _choose_head(method, found, bank, seed, calibrate)
    head, training = head_settings(method, found, bank, choice.candidate)
    model = _trained(method, found, bank, seed, choice.candidate, found.train)
    model.calibration = choice.calibration
    both = len(method.modalities) > 1
    return Outcome(
        logits=partial(_head_logits, model, method.modalities, choice),
        features=partial(_head_features, model, method.modalities),
        choice=choice,
        separate=("vis_branch", "tac_branch") if both else None,
        chosen={"order": model.order, **choice_record(choice)},
        parameters=parameter_count(head),
        guard=_guard(model, found, bank if training.lang and both else None, seed),
    )


def _choose_head(
    method: Method, found: Task, bank: LangBank | None, seed: int, calibrate: bool
) -> Choice:
    """Choose the candidate with the lowest log loss on held-out pairs, as for the baselines. Then
    choose fusion and temperatures on those pairs and under imitated sensors."""
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
    if calibrate and "fusion" not in method.head:
        fusion = chosen_fusion(own.logits, own.labels)
    return Choice(
        candidate=best,
        fusion=fusion,
        calibration=fit_calibration(own.logits, own.labels, fusion=fusion)
        if calibrate
        else Calibration(),
        losses=losses if len(names) > 1 else {},
    )


def _trained(
    method: Method,
    found: Task,
    bank: LangBank | None,
    seed: int,
    candidate: str,
    pairs: Embeddings,
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


def _head_logits(
    model: OmniVaT, modalities: tuple[str, ...], choice: Choice, pairs: Embeddings
) -> dict[str, Tensor]:
    logits = predicted_logits(model, pairs, modalities=modalities)
    return with_fused(logits, choice.fusion, choice.calibration.share)


@torch.no_grad()
def _head_features(
    model: OmniVaT, modalities: tuple[str, ...], pairs: Embeddings
) -> dict[str, Tensor]:
    """Return F-hat of each modality alone, and both branches concatenated as "pair"."""
    rows = {n: tensor(getattr(pairs, n)) if n in modalities else None for n in ("vis", "tac")}
    alone = {
        name: model(*(x if n == name else None for n, x in rows.items())).f_hat[name]
        for name in modalities
    }
    return {**alone, "pair": torch.cat(list(model(rows["vis"], rows["tac"]).f_hat.values()), -1)}


def _guard(
    model: OmniVaT, found: Task, bank: LangBank | None, seed: int
) -> dict[str, float] | None:
    if bank is None or not len(found.source_test):
        return None
    return lang_guard(model, found.source_test, bank.for_classes(found.classes), seed=seed)
