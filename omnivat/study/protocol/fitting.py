"""Fit one method on one source.

A baseline chooses its settings on held-out objects of the source, a quarter of each class
(`omnivat.study.baselines.evidence`)."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeVar

import torch

from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.encoders.lang.clip_prompts import load_prompts
from omnivat.head.head import OmniVaT, parameter_count
from omnivat.head.predict_set import label_map, predicted_probabilities
from omnivat.head.settings import HeadSettings
from omnivat.kit.config import settings_from
from omnivat.kit.errors import DataError
from omnivat.kit.seeding import derive_seed
from omnivat.kit.tables import load
from omnivat.measure.guard import lang_guard
from omnivat.study.baselines import BASELINES
from omnivat.study.baselines.contract import Fitted, Predict, Rows, Source
from omnivat.study.protocol.images import inputs, live_of, require_own_images, tensor
from omnivat.study.protocol.methods import Method
from omnivat.study.protocol.settings import Task
from omnivat.training import TrainSettings, train

T = TypeVar("T")


def source_arrays(task: Task, bank: LangBank | None, seed: int) -> Source:
    """Return the training pairs of a task as arrays for baselines.

    A LANG bank that lacks a class is left out; `why_no_lang` has the reason.
    """
    pairs = task.train
    labels = label_map(task.classes, pairs.header.classes)[pairs.label]
    texts, why = (
        _or_why(lambda: bank.for_classes(task.classes)) if bank else (None, "No LANG bank is used.")
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
        classes=task.classes,
        **of_text,
        live=live,
        why_not_live=why_not_live,
        seed=derive_seed(seed, "baselines", task.setting.domain),
    )


def _or_why(get: Callable[[], T]) -> tuple[T | None, str]:
    try:
        return get(), ""
    except DataError as error:
        return None, str(error)


Probabilities = Callable[[Embeddings], Rows]


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """A fitted method, and the contents of its record.

    probabilities  pairs -> reading -> (N, K): "fused", "vis", "tac" and, of a head, "vis_branch"
                   and "tac_branch"
    features       pairs -> (N, W), the last before classification: "vis", "tac" and "pair"
    """

    probabilities: Probabilities
    features: Probabilities
    chosen: dict[str, Any] = field(default_factory=dict)
    parameters: int = 0
    guard: dict[str, float] | None = None


def fit_baseline(
    method: Method, task: Task, bank: LangBank | None, seed: int, settled: tuple[str, ...]
) -> Outcome:
    """Fit a baseline, with settings chosen on held-out objects.

    settled  names of candidates that another seed chose; they are not chosen again
    Raises a child of OmniVatError if the method cannot run on these pairs.
    """
    begin = load(BASELINES, method.base, kind="baseline")
    arrays = source_arrays(task, bank, seed)
    fitted: Fitted = begin(replace(arrays, **method.train, settled=settled))
    if fitted.images:
        for pairs in (task.train, task.source_test, *task.targets.values()):
            require_own_images(pairs)
    return Outcome(
        probabilities=partial(_joined, fitted.predict, fitted),
        features=partial(_joined, fitted.features, fitted),
        chosen=dict(fitted.chosen),
        parameters=fitted.parameters,
    )


def _joined(read: Predict, fitted: Fitted, pairs: Embeddings) -> Rows:
    """Return what `read`, of a fitted method, returns for all pairs."""
    found = [read(*given) for given in inputs(fitted, pairs)]
    return {name: torch.cat([part[name] for part in found]) for name in found[0]}


def head_settings(
    method: Method, task: Task, bank: LangBank | None
) -> tuple[HeadSettings, TrainSettings]:
    """Return a method's settings on a task."""
    training = settings_from(TrainSettings, method.train)
    width = bank.width if bank and training.lang else 1
    given = {"classes": task.classes, "input_width": task.train.width, "lang_width": width}
    return settings_from(HeadSettings, {**given, **method.head}), training


def fit_head(
    method: Method, task: Task, bank: LangBank | None, seed: int, settled: tuple[str, ...]
) -> Outcome:
    """Train a head; its settings are stated, so `settled` is empty."""
    head, training = head_settings(method, task, bank)
    texts = bank.for_classes(task.classes) if bank and training.lang else None
    model = train(task.train, head, training, bank=texts, seed=seed).model
    guard = None
    if texts is not None and len(method.modalities) > 1 and len(task.source_test):
        guard = lang_guard(model, task.source_test, texts, seed=seed)
    return Outcome(
        probabilities=partial(predicted_probabilities, model, modalities=method.modalities),
        features=partial(_head_features, model, method.modalities),
        chosen={"order": model.order},
        parameters=parameter_count(head),
        guard=guard,
    )


@torch.no_grad()
def _head_features(model: OmniVaT, modalities: tuple[str, ...], pairs: Embeddings) -> Rows:
    """Return F-hat of each modality alone, and both branches concatenated as "pair"."""
    rows = {n: tensor(getattr(pairs, n)) if n in modalities else None for n in ("vis", "tac")}
    alone = {
        name: model(*(x if n == name else None for n, x in rows.items())).f_hat[name]
        for name in modalities
    }
    return {**alone, "pair": torch.cat(list(model(rows["vis"], rows["tac"]).f_hat.values()), -1)}
