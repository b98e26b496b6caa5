"""Run what is not finished yet: in sequence, or in parallel processes."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from omnivat.data.store import Embeddings, load_embeddings
from omnivat.encoders.lang.bank import LangBank, load_bank
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.threads import in_processes, one_thread, pin_thread
from omnivat.study.protocol import records
from omnivat.study.protocol.methods import HEAD, Method
from omnivat.study.protocol.run import Run, execute, heading
from omnivat.study.protocol.settings import task


def planned(methods: Sequence[Method], sources: Sequence[str], seeds: Sequence[int]) -> list[Run]:
    """Return all combinations, methods innermost, so that first table rows appear early."""
    return [
        Run(method=method, source=source, seed=seed)
        for seed in seeds
        for source in sources
        for method in methods
    ]


def run_all(
    runs: Sequence[Run],
    out: Path,
    *,
    embeddings: Path,
    bank: Path | None,
    jobs: int = 1,
    on_step: OnStep = ignore,
) -> int:
    """Run and append the records to `out`; finished runs are skipped.

    embeddings, bank  files; every worker opens them itself
    jobs              parallel processes, one thread each
    return            the number of new runs
    """
    pairs, texts = _opened(embeddings, bank)
    shared = records.provenance(pairs, texts)
    records.mend(out)
    known = {r["key"]: r for r in records.read(out) if r["format"] == records.FORMAT}

    def key(run: Run) -> str:
        return records.key(shared | heading(run, task(pairs, run.source), texts))

    waiting = [run for run in runs if key(run) not in known]
    first, done = min((run.seed for run in runs), default=0), 0
    free = [run for run in waiting if run.seed == first or run.method.base == HEAD]
    bound = [run for run in waiting if run.seed != first and run.method.base != HEAD]

    def settled(run: Run) -> Run:  # the first seed of a baseline chooses for all
        chosen = known.get(key(replace(run, seed=first)), {}).get("chosen", {}).values()
        return replace(run, settled=tuple(name for name in chosen if isinstance(name, str)))

    for part in (free, map(settled, bound)):
        for record in _results(list(part), pairs, texts, jobs, embeddings, bank):
            done += 1
            line = {"key": records.key(shared | record), **shared, **record}
            known[line["key"]] = line
            records.append(out, line)
            text = f"{record['label']}, {record['source']}, seed {record['seed']}"
            on_step(Step(done=done, total=len(waiting), text=text))
    return done


def _results(
    runs: Sequence[Run], pairs: Embeddings, texts: LangBank | None, jobs: int, *files: Path | None
) -> Iterator[records.Record]:
    if jobs > 1 and len(runs) > 1:
        yield from in_processes(_work, runs, jobs, _prepare, *files)
        return
    with one_thread():  # as in a worker, because the number of threads changes the last bits
        for run in runs:
            yield execute(run, pairs, texts)


_OPEN: list[tuple[Embeddings, LangBank | None]] = []  # of a worker process


def _prepare(embeddings: Path, bank: Path | None) -> None:
    pin_thread()
    _OPEN.append(_opened(embeddings, bank))


def _work(run: Run) -> records.Record:
    return execute(run, *_OPEN[0])


def _opened(embeddings: Path, bank: Path | None) -> tuple[Embeddings, LangBank | None]:
    return load_embeddings(embeddings), None if bank is None else load_bank(bank)
