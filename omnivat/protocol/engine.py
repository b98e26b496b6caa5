"""Do the runs that are not done yet: one after another, in processes, or on a ray cluster."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import torch

from omnivat.data.store import Embeddings, load_embeddings
from omnivat.lang.bank import LangBank, load_bank
from omnivat.packages import need
from omnivat.progress import OnStep, Step, ignore
from omnivat.protocol import records
from omnivat.protocol.methods import Method
from omnivat.protocol.run import Run, execute, resolved
from omnivat.protocol.settings import task

ENGINES = ("local", "ray")


def planned(
    methods: Sequence[Method],
    sources: Sequence[str],
    seeds: Sequence[int],
    folds: Sequence[int | None] = (None,),
) -> list[Run]:
    """Return every combination, methods innermost: a first table row is there early."""
    return [
        Run(method=method, source=source, seed=seed, fold=fold)
        for fold in folds
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
    engine: str = "local",
    on_step: OnStep = ignore,
) -> int:
    """Do the runs and append their records to `out`; those that are there already are skipped.

    embeddings, bank  files; every worker opens them itself
    jobs              processes side by side, one thread each
    engine            "local", or "ray" for a cluster that sees the same files
    return            how many runs were done now
    """
    pairs, texts = _opened(embeddings, bank)
    shared = records.provenance(pairs, texts)
    records.mend(out)
    known = {record["key"] for record in records.read(out)}
    waiting = [run for run in runs if _key(run, pairs, texts, shared) not in known]
    for done, record in enumerate(_results(waiting, embeddings, bank, jobs, engine), start=1):
        line = shared | record
        records.append(out, {"key": records.key(line), **line})
        text = f"{record['label']}, {record['source']}, seed {record['seed']}"
        on_step(Step(done=done, total=len(waiting), text=text))
    return len(waiting)


def _key(run: Run, pairs: Embeddings, bank: LangBank | None, shared: dict[str, Any]) -> str:
    found = task(pairs, run.source)
    return records.key(
        shared
        | {
            "method": run.method.name,
            "base": run.method.base,
            "settings": resolved(run.method, found, bank),
            "source": pairs.header.domains[int(found.train.domain[0])],
            "part": found.setting.source.part,
            "seed": run.seed,
            "fold": run.fold,
        }
    )


def _results(
    runs: Sequence[Run], embeddings: Path, bank: Path | None, jobs: int, engine: str
) -> Iterable[dict[str, Any]]:
    if engine == "ray":
        return _by_ray(runs, embeddings, bank)
    if jobs == 1 or len(runs) < 2:
        return _one_by_one(runs, embeddings, bank)
    return _in_processes(runs, embeddings, bank, jobs)


def _one_by_one(
    runs: Sequence[Run], embeddings: Path, bank: Path | None
) -> Iterator[dict[str, Any]]:
    threads = torch.get_num_threads()
    torch.set_num_threads(1)  # as in a worker: the number of threads changes the last bits
    try:
        pairs, texts = _opened(embeddings, bank)
        for run in runs:
            yield execute(run, pairs, texts)
    finally:
        torch.set_num_threads(threads)


def _in_processes(
    runs: Sequence[Run], embeddings: Path, bank: Path | None, jobs: int
) -> Iterator[dict[str, Any]]:
    with ProcessPoolExecutor(
        jobs, mp_context=get_context("spawn"), initializer=_prepare, initargs=(embeddings, bank)
    ) as pool:
        try:
            for done in as_completed([pool.submit(_work, run) for run in runs]):
                yield done.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


_OPEN: dict[str, tuple[Embeddings, LangBank | None]] = {}  # of a worker process


def _prepare(embeddings: Path, bank: Path | None) -> None:
    torch.set_num_threads(1)
    _OPEN["files"] = _opened(embeddings, bank)


def _work(run: Run) -> dict[str, Any]:
    return execute(run, *_OPEN["files"])


def _by_ray(runs: Sequence[Run], embeddings: Path, bank: Path | None) -> Iterator[dict[str, Any]]:
    ray = need("ray", purpose="running on a cluster", install="ray")
    ray.init(ignore_reinit_error=True)
    remote: Callable[..., Any] = ray.remote(_on_cluster).remote
    waiting = [remote(run, str(embeddings), None if bank is None else str(bank)) for run in runs]
    while waiting:
        done, waiting = ray.wait(waiting, num_returns=1)
        yield ray.get(done[0])


def _on_cluster(run: Run, embeddings: str, bank: str | None) -> dict[str, Any]:
    return next(iter(_one_by_one([run], Path(embeddings), None if bank is None else Path(bank))))


def _opened(embeddings: Path, bank: Path | None) -> tuple[Embeddings, LangBank | None]:
    return load_embeddings(embeddings), None if bank is None else load_bank(bank)
