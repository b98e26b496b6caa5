"""One run: fit one method on one source with one seed, and predict every target."""

import time
from dataclasses import asdict, dataclass
from typing import Any

from omnivat.data.domains import paper_name
from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.kit.errors import OmniVatError
from omnivat.study.protocol.fitting import fit, head_settings
from omnivat.study.protocol.methods import HEAD, Method
from omnivat.study.protocol.scoring import object_numbers, score
from omnivat.study.protocol.settings import Task, task


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """One run in plain values, which can be sent to another process or machine."""

    method: Method
    source: str
    seed: int
    settled: tuple[str, ...] = ()  # names of candidates that a baseline's first seed chose here


def execute(run: Run, embeddings: Embeddings, bank: LangBank | None) -> dict[str, Any]:
    """Return the record of a run: resolved settings, scores on the source's test and each target.

    If a method cannot run on these embeddings, or its training fails, the record has "skipped"
    with the reason in one sentence.
    """
    found = task(embeddings, run.source)
    record: dict[str, Any] = {
        "method": run.method.name,
        "label": run.method.label or run.method.name,
        "note": run.method.note,
        "base": run.method.base,
        "ablated": run.method.ablated,
        "source": embeddings.header.domains[int(found.train.domain[0])],
        "part": found.setting.source.part,
        "seed": run.seed,
        "classes": list(found.classes),
        "pairs": len(found.train),
        "settings": resolved(run, found, bank),
        "missing_targets": list(found.missing),
    }
    started = time.perf_counter()
    try:
        outcome = fit(run.method, found, bank, seed=run.seed, settled=run.settled)
    except OmniVatError as error:
        return record | {"skipped": str(error)}
    record |= {
        "seconds": round(time.perf_counter() - started, 2),
        "chosen": outcome.chosen,
        "parameters": outcome.parameters,
    }
    if outcome.guard is not None:
        record["lang_guard"] = outcome.guard
    numbers = object_numbers(embeddings)
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


def resolved(run: Run, task: Task, bank: LangBank | None) -> dict[str, Any]:
    """Return the settings of a run: all of a head; a baseline chooses its own."""
    if run.method.base != HEAD:
        return {"train": dict(run.method.train)} if run.method.train else {}
    head, training = head_settings(run.method, task, bank)
    return {
        "head": asdict(head),
        "train": asdict(training),
        "modalities": list(run.method.modalities),
    }
