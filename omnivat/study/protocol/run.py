"""One run: fit one method on one source with one seed, and predict every target."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from omnivat.data.domains import paper_name
from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.head.fusion import Calibration
from omnivat.kit.config import settings_dict
from omnivat.kit.errors import OmniVatError
from omnivat.study.protocol.fitting import Choice, fit, head_settings
from omnivat.study.protocol.methods import HEAD, Method
from omnivat.study.protocol.scoring import object_numbers, score
from omnivat.study.protocol.settings import Task, task
from omnivat.training.selection import evidence


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """One run in plain values, which can be sent to another process or machine."""

    method: Method
    source: str
    seed: int
    fold: int | None = None  # of source-side evidence, whose targets are held-out objects
    calibrate: bool = False  # fit temperatures, which costs one more training
    prior: Choice | None = None  # what the first seed chose on this source


def execute(run: Run, embeddings: Embeddings, bank: LangBank | None) -> dict[str, Any]:
    """Return the record of a run: resolved settings, scores on the source's test and each target.

    If a method cannot run on these embeddings, or its training fails, the record has "skipped"
    with the reason in one sentence.
    """
    found = task_of(run, embeddings)
    record: dict[str, Any] = {
        "method": run.method.name,
        "label": run.method.label or run.method.name,
        "note": run.method.note,
        "base": run.method.base,
        "ablated": run.method.ablated,
        "source": embeddings.header.domains[int(found.train.domain[0])],
        "part": found.setting.source.part,
        "seed": run.seed,
        "fold": run.fold,
        "classes": list(found.classes),
        "pairs": len(found.train),
        "settings": resolved(run, found, bank),
        "missing_targets": list(found.missing),
    }
    started = time.perf_counter()
    try:
        outcome = fit(
            run.method, found, bank, seed=run.seed, calibrate=run.calibrate, prior=run.prior
        )
    except OmniVatError as error:
        return record | {"skipped": str(error)}
    record |= {
        "seconds": round(time.perf_counter() - started, 2),
        "chosen": outcome.chosen,
        "parameters": outcome.parameters,
        "temperature": dict(outcome.choice.calibration.temperature),
        "share": outcome.choice.calibration.share,
    }
    if outcome.guard is not None:
        record["lang_guard"] = outcome.guard
    numbers = object_numbers(embeddings) if run.fold is None else None
    if len(found.source_test):
        record["source_test"] = score(outcome, found.source_test, found.classes, numbers)
    parts = {side.domain: side.part for side in found.setting.targets}
    record["targets"] = {
        name: {
            "part": parts.get(paper_name(name), ""),
            **score(outcome, pairs, found.classes, numbers),
        }
        for name, pairs in found.targets.items()
    }
    return record


def choice_of(record: Mapping[str, Any]) -> Choice | None:
    """Return the choices in a record, for other seeds of its source; None if it was skipped."""
    if "targets" not in record:
        return None
    chosen = record["chosen"]
    return Choice(
        candidate=chosen.get("settings", ""),
        fusion=chosen.get("fusion", "mean"),
        calibration=Calibration(temperature=record["temperature"], share=record["share"]),
        losses=chosen.get("held-out log loss", {}),
        settled=tuple(value for value in chosen.values() if isinstance(value, str)),
    )


def task_of(run: Run, embeddings: Embeddings) -> Task:
    """Return the task of a run: targets of the paper, or a fold of source-side evidence."""
    found = task(embeddings, run.source)
    if run.fold is None:
        return found
    fold = evidence(found.train, run.fold)
    nothing = found.source_test.select(found.source_test.label < 0)
    return replace(found, train=fold.fit, targets=fold.held, source_test=nothing, missing=())


def resolved(run: Run, found: Task, bank: LangBank | None) -> dict[str, Any]:
    """Return the settings of a run: all of a head; a baseline chooses its own."""
    shared: dict[str, Any] = {"calibrate": run.calibrate}
    if run.method.base != HEAD:
        return shared | ({"train": dict(run.method.train)} if run.method.train else {})
    head, training = head_settings(run.method, found, bank)
    return shared | {
        "head": settings_dict(head),
        "train": settings_dict(training),
        "modalities": list(run.method.modalities),
        "candidates": {name: dict(c) for name, c in run.method.candidates.items()},
    }
