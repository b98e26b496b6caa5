"""Fit one method on one source: choose its settings, fit its temperatures, train it on all pairs.

Choices and temperatures use held-out objects of the source, a quarter of each class. For one seed,
the head and the baselines hold out the same objects (`omnivat.study.baselines.evidence.folds`)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import nll_loss

from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.encoders.lang.clip_prompts import load_prompts
from omnivat.head.calibration import fit_calibration, fit_temperature
from omnivat.head.fusion import LATE, Calibration, fused_logs
from omnivat.head.head import OmniVaT, parameter_count
from omnivat.head.settings import HeadSettings
from omnivat.kit.config import settings_from
from omnivat.kit.errors import DataError
from omnivat.kit.seeding import derive_seed
from omnivat.kit.tables import load
from omnivat.measure.evaluate import label_map, predicted_logits
from omnivat.study.baselines import BASELINES
from omnivat.study.baselines.contract import Fitted, Predict, Source
from omnivat.study.baselines.evidence import folds
from omnivat.study.protocol.images import inputs, live_of, require_own_images, tensor
from omnivat.study.protocol.methods import HEAD, Method
from omnivat.study.protocol.settings import Task
from omnivat.training import TrainSettings, train
from omnivat.training.held_out import HeldOut, held_out_logits, lang_guard
from omnivat.training.selection import Evidence, evidence_of

SMALLEST = 1e-12  # probabilities are raised to this before a logarithm
BRANCHES = ("vis_branch", "tac_branch")  # of a head, inside a pair
T = TypeVar("T")


def source_arrays(
    found: Task, bank: LangBank | None, seed: int, pairs: Embeddings | None = None
) -> Source:
    """Return training pairs as arrays for baselines; `pairs` None: all of the task.

    A LANG bank that lacks a class is left out; `why_no_lang` has the reason.
    """
    pairs = found.train if pairs is None else pairs
    labels = label_map(found.classes, pairs.header.classes)[pairs.label]
    texts, why = (
        _or_why(lambda: bank.for_classes(found.classes))
        if bank
        else (None, "No LANG bank is used.")
    )
    live, why_not_live = _or_why(lambda: live_of(pairs))
    of_text: dict[str, Any] = {"why_no_lang": why}
    if texts is not None:
        of_text = {
            "lang": tensor(texts.embeddings),
            "lang_of_images": texts.is_of(pairs.header),
            "plain": None if texts.plain is None else tensor(texts.plain),
            "logit_scale": texts.logit_scale,
            "prompts": partial(load_prompts, texts.encoder, texts.text_hash)
            if texts.text_hash
            else None,
        }
    return Source(
        vis=tensor(pairs.vis),
        tac=tensor(pairs.tac),
        vis_flip=None if pairs.vis_flip is None else tensor(pairs.vis_flip),
        tac_flip=None if pairs.tac_flip is None else tensor(pairs.tac_flip),
        labels=torch.from_numpy(labels),
        objects=tuple(pairs.rows["object"]),
        classes=found.classes,
        **of_text,
        live=live,
        why_not_live=why_not_live,
        seed=derive_seed(seed, "baselines", found.setting.source.domain),
    )


def _or_why(get: Callable[[], T]) -> tuple[T | None, str]:
    try:
        return get(), ""
    except DataError as error:
        return None, str(error)


def fold_of(found: Task, seed: int) -> Evidence | None:
    """Return the first fold of the baselines; None if no object can be held out."""
    splits = folds(source_arrays(found, None, seed), 1)
    if not splits:
        return None
    held = np.zeros(len(found.train), dtype=bool)
    held[splits[0][1].numpy()] = True
    return evidence_of(found.train, held, derive_seed(seed, "imitated sensors"))


Logits = Callable[[Embeddings], dict[str, Tensor]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """Choices made on held-out objects of a source: once for each source, for all seeds."""

    candidate: str = ""  # name of the head's settings among `Method.candidates`
    # late fusion that held-out pairs favour; "fused" remains the method's own fusion
    fusion: str = "mean"
    # temperatures, and the share of a learned fusion
    calibration: Calibration = field(default_factory=Calibration)
    losses: Mapping[str, float] = field(default_factory=dict)  # held-out log loss of each candidate
    settled: tuple[str, ...] = ()  # names of the candidates that a baseline chose


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """A fitted method, and the contents of its record.

    logits  pairs -> reading -> logits or log-probabilities (N, K) before any temperature: "fused",
            "vis", "tac" and, of a head, "vis_branch", "tac_branch" and "pair"
    """

    logits: Logits
    features: Logits  # (N, W), the last before classification: "vis", "tac" and "pair"
    choice: Choice
    separate: tuple[str, str] | None  # readings for late fusion; None if the method fuses features
    chosen: dict[str, Any] = field(default_factory=dict)
    parameters: int = 0
    guard: dict[str, float] | None = None


def choice_record(choice: Choice) -> dict[str, Any]:
    """Return a choice for the record."""
    head = (
        {"settings": choice.candidate, "held-out log loss": dict(choice.losses)}
        if choice.losses
        else {}
    )
    return {"fusion": choice.fusion, **head}


def fusions(
    logits: Mapping[str, Tensor], separate: tuple[str, str], share: float
) -> dict[str, Tensor]:
    """Return logits (N, K) of every late fusion of two readings, and of summed features if any."""
    vis, tac = (logits[name] for name in separate)
    mixed = {kind: fused_logs(kind, vis, tac, share) for kind in LATE}
    return mixed | ({"feature": logits["pair"]} if "pair" in logits else {})


def chosen_fusion(logits: Mapping[str, Tensor], labels: Tensor) -> str:
    """Return the late fusion with the lowest log loss on held-out pairs, each at its temperature.

    logits  as for `fit_calibration`; fusion needs two branches
    """
    if "vis_branch" not in logits:
        return "mean"
    mixed = fusions(logits, BRANCHES, fit_calibration(logits, labels).share)

    def loss(kind: str) -> float:
        tempered_logs = torch.log_softmax(
            mixed[kind] / fit_temperature(mixed[kind], labels), dim=-1
        )
        return round(float(nll_loss(tempered_logs, labels)), 9)

    return min(mixed, key=loss)


def with_fused(logits: Mapping[str, Tensor], fusion: str, share: float = 0.5) -> dict[str, Tensor]:
    """Add "fused": the fused branches, or the only modality."""
    single = "vis_branch" not in logits
    return {
        **logits,
        "fused": next(iter(logits.values()))
        if single
        else fusions(logits, BRANCHES, share)[fusion],
    }


def fit_baseline(
    method: Method,
    found: Task,
    bank: LangBank | None,
    seed: int,
    calibrate: bool,
    prior: Choice | None,
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
    few = _joined(fitted.predict, fitted, found.train.select(np.arange(len(found.train)) < 8))
    late = torch.allclose(few["fused"], (few["vis"] + few["tac"]) / 2, atol=1e-6)
    # Temperatures also use imitated sensors, which shift embeddings, not images.
    wanted = calibrate and prior is None and fitted.images is None
    fold = fold_of(found, seed) if wanted else None
    if fold is not None:
        held = held_out_logits(fold, found.classes, partial(_baseline_logs, start(fold.fit)))
        logits = held.logits
        if late:
            logits |= {"vis_branch": logits["vis"], "tac_branch": logits["tac"]}
        choice = Choice(
            fusion=chosen_fusion(logits, held.labels),
            calibration=fit_calibration(logits, held.labels),
        )
    return Outcome(
        logits=partial(_baseline_logs, fitted),
        features=partial(_joined, fitted.features, fitted),
        choice=choice,
        separate=("vis", "tac") if late else None,
        chosen=dict(fitted.chosen) | (choice_record(choice) if late else {}),
        parameters=fitted.parameters,
    )


def _baseline_logs(fitted: Fitted, pairs: Embeddings) -> dict[str, Tensor]:
    found = _joined(fitted.predict, fitted, pairs)
    return {name: values.clamp_min(SMALLEST).log() for name, values in found.items()}


def _joined(read: Predict, fitted: Fitted, pairs: Embeddings) -> dict[str, Tensor]:
    """Return what `read`, of a fitted method, returns for all pairs."""
    found = [read(*given) for given in inputs(fitted, pairs)]
    return {name: torch.cat([part[name] for part in found]) for name in found[0]}


def head_settings(
    method: Method, found: Task, bank: LangBank | None, candidate: str = ""
) -> tuple[HeadSettings, TrainSettings]:
    """Return a method's settings on a task; `candidate` names one of `method.candidates`."""
    changes = method.candidates.get(candidate, {})
    training = settings_from(TrainSettings, {**method.train, **changes.get("train", {})})
    width = bank.width if bank and training.lang else 1
    given = {"classes": found.classes, "input_width": found.train.width, "lang_width": width}
    return settings_from(
        HeadSettings, {**given, **method.head, **changes.get("head", {})}
    ), training


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
        logits=lambda pairs: with_fused(
            predicted_logits(model, pairs, modalities=method.modalities),
            stated_fusion(method),
            choice.calibration.share,
        ),
        features=partial(_head_features, model, method.modalities),
        choice=choice,
        separate=BRANCHES if both else None,
        chosen={"order": model.order, **choice_record(choice)},
        parameters=parameter_count(head),
        guard=lang_guard(model, found.source_test, bank.for_classes(found.classes), seed=seed)
        if bank and training.lang and both and len(found.source_test)
        else None,
    )


def _choose_head(
    method: Method, found: Task, bank: LangBank | None, seed: int, calibrate: bool
) -> Choice:
    """Choose the candidate with the lowest log loss on held-out pairs, as for the baselines. Then
    choose a fusion, and fit temperatures, on those pairs and under imitated sensors."""
    names, fusion = tuple(method.candidates) or ("",), stated_fusion(method)
    fold = fold_of(found, seed) if calibrate or len(names) > 1 else None
    if fold is None:
        return Choice(candidate=names[0], fusion=fusion)
    held: dict[str, HeldOut] = {}
    for name in names:
        model = _trained(method, found, bank, seed, name, fold.fit)
        held[name] = held_out_logits(
            fold, found.classes, partial(predicted_logits, model, modalities=method.modalities)
        )
    losses = {name: held_out_loss(one, fusion) for name, one in held.items()}
    best = min(losses, key=losses.__getitem__)
    own = held[best]
    return Choice(
        candidate=best,
        fusion=chosen_fusion(own.logits, own.labels) if calibrate else fusion,
        calibration=fit_calibration(own.logits, own.labels, fusion=fusion)
        if calibrate
        else Calibration(),
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


def fit(
    method: Method,
    found: Task,
    bank: LangBank | None,
    *,
    seed: int,
    calibrate: bool,
    prior: Choice | None = None,
) -> Outcome:
    """Fit a method on the task's training pairs.

    calibrate  also choose the fusion and fit temperatures, with one more training for each
               candidate on three quarters of the objects
    prior      choices of another seed on this source; they are not made again
    Raises a child of OmniVatError if the method cannot run on these pairs.
    """
    fitted = fit_head if method.base == HEAD else fit_baseline
    return fitted(method, found, bank, seed, calibrate, prior)
