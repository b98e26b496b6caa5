"""A separate head at each order: many trainings with p fixed, in parallel processes, resumable, and
the frames of all.

`<folder>/p0.3500/seed0` is an ordinary head folder. Its metrics.json also has "measures", those of
`omnivat.maps.epochs.Meter`. A finished head is not trained again.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import fmean, stdev
from typing import Any

from omnivat.head.checkpoint import SETTINGS, Head, load_head, save_head
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.files import require_writable
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.threads import in_processes, pin_thread
from omnivat.maps.epochs import Meter
from omnivat.maps.frames.builder import FrameBuilder
from omnivat.maps.frames.records import FrameSet
from omnivat.maps.sweep import MEASURES, STAGES, STILL, walk
from omnivat.measure.known import scored
from omnivat.training import TrainingPlan, trained_head

MAPS: Mapping[str, int] = {
    **{f"pca/{stage}": 1001 for stage in STAGES},
    "umap/raw": 1,
    "umap/f_hat": 1001,
}
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
    head = scored(trained_head(own, calibrate=False), own.embeddings)
    meter = Meter(own.embeddings, own.settings.classes, own.source)
    head.metrics["measures"] = meter.measures(meter.at(head.model, stop[0]))
    head.provenance["run"] = own.name
    save_head(stop_folder(folder, *stop), replace(head, familiarity=None))


def retrained_frames(
    plan: TrainingPlan,
    orders: Sequence[float],
    folder: Path,
    *,
    seeds: Sequence[int] = (0,),
    maps: Mapping[str, int] = MAPS,
    measures: Sequence[str] = MEASURES,
    on_step: OnStep = ignore,
) -> FrameSet:
    """Return the frames of the heads that `heads_at_stops` wrote to `folder`.

    Maps, predictions and most curves come from the first seed's heads. Curves whose names start
    with "seeds:" hold mean, standard deviation (n - 1), minimum and maximum over all seeds.

    Raises DataError if a head is missing.
    """
    # with a projection of its own each, heads differ in distances after the transform, too
    still = ("raw",) if plan.settings.projects else STILL
    builder = FrameBuilder(
        plan.settings,
        plan.embeddings,
        orders=orders,
        maps=maps,
        measures=measures,
        source=plan.source,
        still=still,
    )
    over_seeds: dict[str, list[float | None]] = {}
    for index, order in enumerate(orders):
        heads = [load_head(stop_folder(folder, order, seed)) for seed in seeds]
        stages = [stage for stage in builder.stages if index == 0 or stage not in still]
        found = next(
            iter(walk(heads[0].model, plan.embeddings, [order], stages=stages, predictions=True))
        )
        builder.add(replace(found, index=index))
        for name, value in _spread(heads).items():
            over_seeds.setdefault(name, [None] * len(orders))[index] = value
        on_step(Step(done=index + 1, total=len(orders), text=f"map of the head at {order:.2f}"))
    builder.curves |= over_seeds
    return builder.finish(
        {
            "kind": "retrained",
            "learned_order": None,
            "source": plan.source,
            "width": plan.settings.width,
            "epochs": plan.training.epochs,
            "seeds": list(seeds),
            "simulated": plan.embeddings.header.simulated,
        }
    )


def _spread(heads: Sequence[Head]) -> dict[str, float | None]:
    """Return "seeds:NAME/mean" and so on for every score of heads that differ only in the seed."""
    each = [_scores(head) for head in heads]
    found: dict[str, float | None] = {}
    for name in (name for name in each[0] if all(name in scores for scores in each)):
        values = [scores[name] for scores in each]
        std = stdev(values) if len(values) > 1 else None
        of_seeds = {"mean": fmean(values), "std": std, "low": min(values), "high": max(values)}
        found |= {f"seeds:{name}/{kind}": value for kind, value in of_seeds.items()}
    return found


def _scores(head: Head) -> dict[str, float]:
    """Return the scores in a head's folder, by curve name."""
    metrics: Mapping[str, Any] = head.metrics
    if "measures" not in metrics:
        raise DataError(f"'{head.path}' holds no measures; remove it and train it again.")
    found = {name: float(value) for name, value in metrics["measures"].items()}
    if metrics.get("target_macro_f1") is not None:
        found["macro_f1/unseen"] = float(metrics["target_macro_f1"])
    for record in metrics["domains"]:
        if record["scores"]:
            found[f"accuracy/{record['domain']}"] = record["scores"]["fused"]["accuracy"]
    return found
