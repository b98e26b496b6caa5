"""Train and finish a head: calibration, familiarity, scores on every domain."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from omnivat.data.profile import STEP_SHIFTED, profile_of
from omnivat.data.store import Embeddings
from omnivat.head.calibration import Familiarity, familiarity_of
from omnivat.head.checkpoint import Head
from omnivat.head.fusion import Calibration
from omnivat.head.head import OmniVaT
from omnivat.kit.errors import DataError
from omnivat.kit.progress import OnStep, ignore, never
from omnivat.measure.evaluate import evaluate, target_mean, target_scores
from omnivat.training import Trained, TrainSettings, Watch, train
from omnivat.training.from_pairs.plan import TrainingPlan, plan_training
from omnivat.training.from_pairs.report import LOSSES, EpochReport, Meter
from omnivat.training.held_out import calibration_of

OnReport = Callable[[EpochReport], None]


def head_from_pairs(
    embeddings: Embeddings,
    source: str,
    *,
    head: Mapping[str, Any] | None = None,
    training: TrainSettings | None = None,
    seed: int = 0,
    calibrate: bool = True,
    on_step: OnStep = ignore,
    on_epoch: OnReport | None = None,
    measure_every: int = 5,
    snapshot: bool = False,
    cancelled: Callable[[], bool] = never,
) -> Head:
    """Train a head on one domain of a set and evaluate it on all; nothing is written to disk.

    embeddings, source, head, training, seed  as for `plan_training`
    calibrate      also fit temperatures to held-out source pairs (half as much time again)
    on_step        called at every optimiser step of the first training
    on_epoch       called with a report after every epoch of it
    measure_every  epochs between reports with measures; the last one always has them
    snapshot       reports with measures also have a map
    cancelled      training stops when it returns True

    Raises the errors of `plan_training`, and TrainingCancelled.
    """
    plan = plan_training(embeddings, source, head=head, training=training, seed=seed)
    watch = Watch(on_step=on_step, cancelled=cancelled)
    if on_epoch is not None:
        watch = replace(watch, on_epoch=_reporter(plan, on_epoch, measure_every, snapshot))
    return trained_head(plan, calibrate=calibrate, watch=watch)


def trained_head(
    plan: TrainingPlan,
    *,
    repeat: Sequence[int] = (),
    calibrate: bool = True,
    resume: Path | None = None,
    watch: Watch | None = None,
) -> Head:
    """Carry out a plan; arguments as in `head_from_pairs`.

    repeat  train again with these seeds; their scores go into metrics["seeds"]
    resume  file for the state after each epoch, from which a stopped training resumes
    """
    watch = watch or Watch()
    trained = _trained(plan, watch, resume)
    provenance = plan.provenance()
    steps = Watch(cancelled=watch.cancelled)
    if calibrate:
        found, how = _calibration(plan, trained.model.order, steps)
        provenance["calibration"] = how
        if found is not None:
            trained.model.calibration = found
    head = Head(
        model=trained.model,
        settings=trained.model.settings,
        encoder=plan.encoder,
        provenance=provenance,
        familiarity=_familiarity(plan.pairs),
        profile=replace(
            profile_of(plan.pairs, domain=plan.source),
            step=STEP_SHIFTED if plan.training.shift else 1.0,
        ),
    )
    head.metrics.update(_metrics(plan, head, trained))
    for seed in repeat:
        other = replace(
            head, model=_trained(replace(plan, seed=seed), steps, None).model, metrics={}
        )
        head.metrics["seeds"].append(_summary(seed, other, evaluate(other, plan.embeddings)))
    return head


def _trained(plan: TrainingPlan, watch: Watch, resume: Path | None) -> Trained:
    return train(
        plan.pairs,
        plan.settings,
        plan.training,
        bank=plan.bank,
        seed=plan.seed,
        resume=resume,
        watch=watch,
    )


def _reporter(
    plan: TrainingPlan, show: OnReport, every: int, snapshot: bool
) -> Callable[[dict[str, float], OmniVaT], None]:
    """Return a function that turns the record of an epoch into a report, with measures if due."""
    total, meter = plan.training.epochs, Meter(plan.embeddings, plan.settings.classes, plan.source)

    def take(record: dict[str, float], model: OmniVaT) -> None:
        epoch, losses = int(record["epoch"]) + 1, {name: record[name] for name in LOSSES}
        report = EpochReport(epoch=epoch, total=total, losses=losses, order=record["order"])
        if epoch == total or (every and epoch % every == 0):
            found = meter.at(model, record["order"])
            points = meter.map(found) if snapshot else None
            report = replace(report, measures=meter.measures(found), map=points)
        show(report)

    return take


def _calibration(plan: TrainingPlan, order: float, watch: Watch) -> tuple[Calibration | None, str]:
    """Fit temperatures at the final order; return them with a note on their origin."""
    settings = replace(plan.settings, order=order)
    training = replace(plan.training, order_search=False)
    try:
        found = calibration_of(
            plan.pairs, settings, training, bank=plan.bank, seed=plan.seed, watch=watch
        )
    except DataError as error:
        return None, f"none: {error}"
    return found, "a quarter of the source's objects, as they are and under imitated sensors"


def _familiarity(source: Embeddings) -> Familiarity | None:
    """Return the head's familiarity; None if all training images are of one object."""
    vis, tac = map(torch.from_numpy, (source.vis, source.tac))
    try:
        return familiarity_of(vis, tac, source.rows["object"])
    except DataError:
        return None


def _metrics(plan: TrainingPlan, head: Head, trained: Trained) -> dict[str, Any]:
    """Return the contents of metrics.json for one training."""
    records = evaluate(head, plan.embeddings)
    summary = _summary(plan.seed, head, records)
    found = {
        "selection": plan.training.selection,
        "chosen_epoch": trained.chosen_epoch,
        **{name: value for name, value in summary.items() if name not in ("seed", "domains")},
        "domains": records,
        "epochs": trained.epochs,
        "seeds": [summary],
    }
    return {**found, "order_search": trained.search} if trained.search else found


def _summary(seed: int, head: Head, records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the scores of one seed: means over targets, and of each domain."""
    means = {
        score: target_mean(target_scores(records), score) for score in ("accuracy", "macro_f1")
    }
    return {
        "seed": seed,
        "order": head.model.order,
        # JSON has no NaN
        **{f"target_{s}": None if math.isnan(mean) else mean for s, mean in means.items()},
        "domains": {r["domain"]: r["scores"]["fused"] for r in records if r["scores"]},
    }
