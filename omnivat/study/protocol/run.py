"""One run: fit one method on one source with one seed, and predict every target."""

import time
from dataclasses import asdict, dataclass

from omnivat.data.domains import paper_name
from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.kit.errors import OmniVatError
from omnivat.study.protocol.fitting import fit_baseline, fit_head, head_settings
from omnivat.study.protocol.methods import HEAD, Method
from omnivat.study.protocol.records import Record
from omnivat.study.protocol.scoring import object_numbers, score
from omnivat.study.protocol.settings import Task, task


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """One run in plain values, which can be sent to another process or machine."""

    method: Method
    source: str
    seed: int
    settled: tuple[str, ...] = ()  # names of candidates that a baseline's first seed chose here


def execute(run: Run, embeddings: Embeddings, bank: LangBank | None) -> Record:
    """Return the record of a run: resolved settings, scores on the source's test and each target.

    If a method cannot run on these embeddings, or its training fails, the record has "skipped"
    with the reason in one sentence.
    """
    work = task(embeddings, run.source)
    record = heading(run, work, bank)
    started = time.perf_counter()
    try:
        fit = fit_head if run.method.base == HEAD else fit_baseline
        outcome = fit(run.method, work, bank, run.seed, run.settled)
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
    if len(work.source_test):
        record["source_test"] = score(outcome, work.source_test, work.classes, numbers)
    record["targets"] = {
        name: {
            "part": work.setting.targets.get(paper_name(name), ""),
            **score(outcome, pairs, work.classes, numbers),
        }
        for name, pairs in work.targets.items()
    }
    return record


def heading(run: Run, task: Task, bank: LangBank | None) -> Record:
    """Return what the record of a run begins with: all that is known before it is fitted."""
    return {
        "method": run.method.name,
        "label": run.method.label or run.method.name,
        "note": run.method.note,
        "base": run.method.base,
        "ablated": run.method.ablated,
        "source": task.train.header.domains[int(task.train.domain[0])],
        "part": task.setting.part,
        "seed": run.seed,
        "classes": list(task.classes),
        "pairs": len(task.train),
        "settings": _resolved(run, task, bank),
        "missing_targets": list(task.missing),
    }


def _resolved(run: Run, task: Task, bank: LangBank | None) -> Record:
    """Return the settings of a run: all of a head; a baseline chooses its own."""
    if run.method.base != HEAD:
        return {"train": dict(run.method.train)} if run.method.train else {}
    head, training = head_settings(run.method, task, bank)
    return {
        "head": asdict(head),
        "train": asdict(training),
        "modalities": list(run.method.modalities),
    }
