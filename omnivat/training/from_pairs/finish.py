"""Train and finish a head: calibration, familiarity, scores on every domain."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from omnivat.data.profile import STEP_SHIFTED, profile_of
from omnivat.head.calibration import familiarity_of, fit_calibration
from omnivat.head.checkpoint import Head
from omnivat.head.fusion import Temperatures
from omnivat.kit.errors import DataError
from omnivat.measure.known import evaluate, target_mean, target_scores
from omnivat.measure.predictions import label_map, predicted_logits
from omnivat.training import Watch
from omnivat.training.from_pairs.plan import TrainingPlan
from omnivat.training.selection import evidence


def trained_head(
    plan: TrainingPlan,
    *,
    repeat: Sequence[int] = (),
    calibrate: bool = True,
    resume: Path | None = None,
    watch: Watch | None = None,
) -> Head:
    """Train a head as planned and evaluate it on all domains of the set; no head is written.

    repeat     train again with these seeds; their scores go into metrics["seeds"]
    calibrate  also fit temperatures to held-out source pairs (half as much time again)
    resume     file for the state after each epoch, from which a stopped training resumes
    watch      callbacks of the first training

    Raises the errors of `train`.

    >>> from omnivat import EXAMPLES, TrainSettings, load_embeddings, plan_training
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> light = TrainSettings(epochs=1, lang=False)
    >>> plan = plan_training(pairs, "Chirps A-sim", head={"width": 16}, training=light)
    >>> head = trained_head(plan, calibrate=False)  # `save_head` writes it
    >>> head.source, len(head.metrics["domains"]), head.profile.counts
    ('Chirps A-sim', 4, {'vis': 100, 'tac': 100})
    """
    trained = plan.train(watch=watch, resume=resume)
    model = trained.model
    provenance = plan.provenance()
    if calibrate:
        how = "a quarter of the source's objects, as they are and under imitated sensors"
        try:
            model.temperatures = calibration_of(plan.searched(model.order))
        except DataError as error:
            how = f"none: {error}"
        provenance["calibration"] = how
    vis, tac = map(torch.from_numpy, (plan.pairs.vis, plan.pairs.tac))
    try:
        known = familiarity_of(vis, tac, plan.pairs.rows["object"])
    except DataError:  # all training images are of one object
        known = None
    profile = profile_of(plan.pairs, domain=plan.source)
    head = Head(
        model=model,
        settings=model.settings,
        encoder=plan.encoder,
        provenance=provenance,
        familiarity=known,
        profile=replace(profile, step=STEP_SHIFTED if plan.training.shift else 1.0),
    )
    records = evaluate(head, plan.embeddings)
    summary = _summary(plan.seed, head, records)
    means = {name: value for name, value in summary.items() if name not in ("seed", "domains")}
    others = []
    for seed in repeat:
        model = replace(plan, seed=seed).train().model
        other = replace(head, model=model)
        others.append(_summary(seed, other, evaluate(other, plan.embeddings)))
    metrics = {
        **means,
        "domains": records,
        "epochs": trained.epochs,
        "seeds": [summary, *others],
        **({"order_search": trained.search} if trained.search else {}),
    }
    return replace(head, metrics=metrics)


def calibration_of(plan: TrainingPlan) -> Temperatures:
    """Fit temperatures to predictions for held-out pairs of the source.

    A head is trained on three quarters of the source's objects with the same settings. It predicts
    the last quarter, as it is and under imitated sensors (omnivat/training/selection.py): with
    plain pairs alone, a head would be as confident on a new sensor as on its own.

    Raises DataError if no object can be held out.
    """
    fit, held = evidence(plan.pairs)
    model, classes = replace(plan, pairs=fit).train().model, plan.settings.classes
    parts = [predicted_logits(model, pairs, modalities=plan.training.given) for pairs in held]
    labels = [label_map(classes, pairs.header.classes)[pairs.label] for pairs in held]
    logits = {name: torch.cat([part[name] for part in parts]) for name in parts[0]}
    truth = torch.from_numpy(np.concatenate(labels))
    return fit_calibration(logits, truth, fusion=plan.settings.fusion)


def _summary(seed: int, head: Head, records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
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
