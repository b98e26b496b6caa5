"""One run: fit one method on one source with one seed, and answer every target."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from torch import Tensor

from omnivat.baselines import BASELINES
from omnivat.baselines.contract import Fitted, Source
from omnivat.config import settings_dict, settings_from
from omnivat.data.domains import paper_name
from omnivat.data.store import Embeddings
from omnivat.errors import OmniVatError
from omnivat.evaluate import label_map, predicted_probabilities
from omnivat.gaps.calibration import ece
from omnivat.gaps.confusion import accuracy, macro_f1
from omnivat.lang.bank import LangBank
from omnivat.model.head import parameter_count
from omnivat.model.settings import HeadSettings
from omnivat.protocol.methods import HEAD, Method
from omnivat.protocol.settings import Task, task
from omnivat.seeding import derive_seed
from omnivat.selection import evidence
from omnivat.tables import load
from omnivat.train import TrainSettings, train

Answer = Callable[[Embeddings], dict[str, Tensor]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """What to do, in plain values: a run can be sent to another process or machine."""

    method: Method
    source: str
    seed: int
    fold: int | None = None  # of source-side evidence: targets are then held-out objects


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """A fitted method, ready to answer, and what the record should tell of it."""

    answer: Answer
    chosen: dict[str, Any]
    parameters: int


def execute(run: Run, embeddings: Embeddings, bank: LangBank | None) -> dict[str, Any]:
    """Return the record of a run: what was resolved, scores on the source's test and each target.

    A method that cannot run on these embeddings, or whose training stops, gives a record with
    "skipped": the reason in one sentence.
    """
    found = asked(run, embeddings)
    record: dict[str, Any] = {
        "method": run.method.name,
        "label": run.method.label or run.method.name,
        "note": run.method.note,
        "base": run.method.base,
        "source": embeddings.header.domains[int(found.train.domain[0])],
        "part": found.setting.source.part,
        "seed": run.seed,
        "fold": run.fold,
        "classes": list(found.classes),
        "pairs": len(found.train),
        "settings": resolved(run.method, found, bank),
        "missing_targets": list(found.missing),
    }
    started = time.perf_counter()
    try:
        fit = _fit_head if run.method.base == HEAD else _fit_baseline
        outcome = fit(run, found, bank)
    except OmniVatError as error:
        return record | {"skipped": str(error)}
    record |= {
        "seconds": round(time.perf_counter() - started, 2),
        "chosen": outcome.chosen,
        "parameters": outcome.parameters,
    }
    if len(found.source_test):
        record["source_test"] = score(outcome.answer, found.source_test, found.classes)
    record["targets"] = {
        name: {"part": _part(found, name), **score(outcome.answer, pairs, found.classes)}
        for name, pairs in found.targets.items()
    }
    return record


def asked(run: Run, embeddings: Embeddings) -> Task:
    """Return the task of a run: targets of the paper, or a fold of source-side evidence."""
    found = task(embeddings, run.source)
    if run.fold is None:
        return found
    fold = evidence(found.train, run.fold)
    nothing = found.source_test.select(found.source_test.label < 0)
    return replace(found, train=fold.fit, targets=fold.held, source_test=nothing, missing=())


def resolved(method: Method, found: Task, bank: LangBank | None) -> dict[str, Any]:
    """Return every setting of the head and of training; nothing for a baseline, which tunes itself."""
    if method.base != HEAD:
        return {}
    head, training = _settings(method, found, bank)
    return {
        "head": settings_dict(head),
        "train": settings_dict(training),
        "modalities": list(method.modalities),
    }


def _settings(
    method: Method, found: Task, bank: LangBank | None
) -> tuple[HeadSettings, TrainSettings]:
    training = settings_from(TrainSettings, method.train)
    lang_width = bank.width if bank and training.lang else 1
    values = {"input_width": found.train.width, "lang_width": lang_width, **method.head}
    return settings_from(HeadSettings, {"classes": found.classes, **values}), training


def _fit_head(run: Run, found: Task, bank: LangBank | None) -> Outcome:
    head, training = _settings(run.method, found, bank)
    used = bank.for_classes(found.classes) if bank and training.lang else None
    trained = train(found.train, head, training, bank=used, seed=run.seed)
    chosen = {"epoch": trained.chosen_epoch, "order": trained.model.order}

    def answer(pairs: Embeddings) -> dict[str, Tensor]:
        return predicted_probabilities(trained.model, pairs, modalities=run.method.modalities)

    return Outcome(answer=answer, chosen=chosen, parameters=parameter_count(head))


def _fit_baseline(run: Run, found: Task, bank: LangBank | None) -> Outcome:
    fit = load(BASELINES, run.method.base, kind="baseline")
    fitted: Fitted = fit(source_arrays(found, bank, run.seed))

    def answer(pairs: Embeddings) -> dict[str, Tensor]:
        return fitted.predict(_tensor(pairs.vis), _tensor(pairs.tac))

    return Outcome(answer=answer, chosen=fitted.chosen, parameters=fitted.parameters)


def source_arrays(found: Task, bank: LangBank | None, seed: int) -> Source:
    """Return the training pairs as baselines take them."""
    pairs = found.train
    labels = label_map(found.classes, pairs.header.classes)[pairs.label]
    lang = None if bank is None else _tensor(bank.for_classes(found.classes).embeddings)
    return Source(
        vis=_tensor(pairs.vis),
        tac=_tensor(pairs.tac),
        vis_flip=None if pairs.vis_flip is None else _tensor(pairs.vis_flip),
        tac_flip=None if pairs.tac_flip is None else _tensor(pairs.tac_flip),
        labels=torch.from_numpy(labels),
        objects=tuple(pairs.rows["object"]),
        classes=found.classes,
        lang=lang,
        lang_of_images=bank is not None and made_by_the_image_encoder(bank, pairs),
        seed=derive_seed(seed, "baselines", found.setting.source.domain),
    )


def made_by_the_image_encoder(bank: LangBank, pairs: Embeddings) -> bool:
    """Tell whether the bank's texts lie in the images' space: its origin names their encoder."""
    return bank.width == pairs.width and pairs.header.encoder in bank.origin


def score(answer: Answer, pairs: Embeddings, classes: tuple[str, ...]) -> dict[str, Any]:
    """Return counts and scores, "fused" and by modality; pairs of unknown classes are left out."""
    labels = label_map(classes, pairs.header.classes)[pairs.label]
    known = np.flatnonzero(labels >= 0)
    truth = torch.from_numpy(labels[known])
    probabilities = answer(pairs.select(known)) if len(known) else {}
    return {
        "pairs": len(known),
        "left_out": len(labels) - len(known),
        "scores": {name: _scores(values, truth) for name, values in probabilities.items()},
    }


def _scores(probabilities: Tensor, truth: Tensor) -> dict[str, float]:
    answers = probabilities.argmax(-1)
    return {
        "accuracy": float(accuracy(truth, answers)),
        "macro_f1": float(macro_f1(truth, answers)),
        "macro_f1_union": float(macro_f1(truth, answers, average="union")),
        "ece": float(ece(probabilities, truth)),
    }


def _part(found: Task, name: str) -> str:
    sides = {side.domain: side.part for side in found.setting.targets}
    return sides.get(paper_name(name), "")


def _tensor(array: Any) -> Tensor:
    return torch.from_numpy(np.array(array, dtype=np.float32))


def target_mean(record: Mapping[str, Any], metric: str = "accuracy", which: str = "fused") -> float:
    """Return the unweighted mean of a score over a record's targets."""
    values = [target["scores"][which][metric] for target in record["targets"].values()]
    return float(np.mean(values)) if values else float("nan")
