"""A separate head at each order: many trainings with p fixed, in parallel processes, resumable.

`<folder>/p0.3500/seed0` is an ordinary head folder. Its metrics.json also has "measures", the gaps
and accuracies of `EpochReport`. A finished head is not trained again.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from omnivat.head.checkpoint import SETTINGS, save_head
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import require_writable
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.threads import in_processes, pin_thread
from omnivat.training.from_pairs.finish import trained_head
from omnivat.training.from_pairs.plan import TrainingPlan
from omnivat.training.from_pairs.report import Meter

Stop = tuple[float, int]  # order, seed


def heads_at_stops(
    plan: TrainingPlan,
    orders: Sequence[float],
    folder: Path,
    *,
    seeds: Sequence[int] = (0,),
    jobs: int = 1,
    on_step: OnStep = ignore,
) -> int:
    """Train a head for every order and seed; write each to its own folder.

    plan    all settings but order and seed; p is fixed
    jobs    parallel processes, one thread each; 1 trains in this process
    return  number of newly trained heads; if the work stops, finished heads stay for the next call

    Raises SettingsError for no order or no seed.
    """
    if not orders or not seeds or jobs < 1:
        raise SettingsError("Heads at stops need one order, one seed and one process or more.")
    require_writable(folder / SETTINGS)
    stops = [(float(order), seed) for seed in seeds for order in orders]
    waiting = [stop for stop in stops if not _is_done(plan, stop, folder)]
    done = len(stops) - len(waiting)
    on_step(Step(done=done, total=len(stops), text="heads that are there already"))
    for order, seed in _carried_out(plan, waiting, folder, jobs):
        done += 1
        on_step(Step(done=done, total=len(stops), text=f"head at p = {order:g}, seed {seed}"))
    return len(waiting)


def stop_folder(folder: Path, order: float, seed: int) -> Path:
    """Return the folder of the head for an order and a seed."""
    return folder / f"p{order:.4f}" / f"seed{seed}"


def _is_done(plan: TrainingPlan, stop: Stop, folder: Path) -> bool:
    """True if the head of a stop exists, with the same pairs and settings."""
    try:
        record = json.loads((stop_folder(folder, *stop) / SETTINGS).read_text(encoding="utf-8"))
        return bool(record["provenance"]["run"] == plan.at(*stop).name)
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _carried_out(
    plan: TrainingPlan, stops: Sequence[Stop], folder: Path, jobs: int
) -> Iterator[Stop]:
    """Yield each stop when its head is written."""
    if jobs > 1:
        yield from in_processes(_work, stops, jobs, _prepare, plan, folder)
        return
    for stop in stops:
        _write_head(plan, stop, folder)
        yield stop


_HELD: dict[str, tuple[TrainingPlan, Path]] = {}  # of a worker process


def _prepare(plan: TrainingPlan, folder: Path) -> None:
    pin_thread()
    _HELD["work"] = (plan, folder)


def _work(stop: Stop) -> Stop:
    plan, folder = _HELD["work"]
    _write_head(plan, stop, folder)
    return stop


def _write_head(plan: TrainingPlan, stop: Stop, folder: Path) -> None:
    own = plan.at(*stop)
    head = trained_head(own, calibrate=False)
    meter = Meter(own.embeddings, own.settings.classes, own.source)
    head.metrics["measures"] = meter.measures(meter.at(head.model, stop[0]))
    head.provenance["run"] = own.name
    save_head(stop_folder(folder, *stop), replace(head, familiarity=None))
