"""From a plan to a head: training, temperatures, familiarity, profile and provenance."""

import platform
from dataclasses import asdict, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import torch

from omnivat.data.profile import STEP_SHIFTED
from omnivat.data.store import Embeddings
from omnivat.head.calibration import familiarity_of, fit_calibration
from omnivat.head.checkpoint import ENCODER, Head
from omnivat.head.fusion import Temperatures
from omnivat.head.predict_set import label_map, predicted_logits
from omnivat.kit.errors import DataError
from omnivat.training.plan import TrainingPlan
from omnivat.training.selection import evidence
from omnivat.training.training import Trained, train
from omnivat.training.watch import UNWATCHED, Watch

PACKAGES = ("torch", "numpy", "safetensors")  # whose versions a head keeps


def trained_head(
    plan: TrainingPlan,
    *,
    calibrate: bool = True,
    resume: str | Path | None = None,
    watch: Watch = UNWATCHED,
) -> Head:
    """Train a head as planned; no head is written. Its metrics hold "epochs" and "order_search".

    calibrate  also fit temperatures to held-out source pairs (half as much time again)
    resume     file for the state after each epoch, from which a stopped training resumes
    watch      callbacks of the training

    Raises the errors of `train`.

    >>> from omnivat import EXAMPLES, TrainSettings, load_embeddings, plan_training
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> light = TrainSettings(epochs=1, lang=False)
    >>> plan = plan_training(pairs, "Chirps A-sim", head={"width": 16}, training=light)
    >>> head = trained_head(plan, calibrate=False)  # `save_head` writes it
    >>> head.source, [*head.metrics], head.profile.counts
    ('Chirps A-sim', ['epochs'], {'vis': 100, 'tac': 100})
    """
    pairs = plan.pairs
    trained = _trained(plan, pairs, resume=resume, watch=watch)
    model, provenance = trained.model, _provenance(plan)
    if calibrate:
        how = "a quarter of the source's objects, as they are and under imitated sensors"
        try:
            model.temperatures = calibration_of(plan, pairs, model.order)
        except DataError as error:
            how = f"none: {error}"
        provenance["calibration"] = how
    vis, tac = map(torch.from_numpy, (pairs.vis, pairs.tac))
    try:
        known = familiarity_of(vis, tac, pairs.rows["object"])
    except DataError:  # all training images are of one object
        known = None
    header, step = plan.embeddings.header, STEP_SHIFTED if plan.training.shift else 1.0
    search = {"order_search": trained.search} if trained.search else {}
    return Head(
        model=model,
        encoder=dict(zip(ENCODER, header.key, strict=True)),
        provenance=provenance,
        familiarity=known,
        profile=replace(trained.profile, domain=plan.source, step=step),
        metrics={"epochs": trained.epochs} | search,
    )


def _trained(
    plan: TrainingPlan,
    pairs: Embeddings,
    *,
    resume: str | Path | None = None,
    watch: Watch = UNWATCHED,
) -> Trained:
    """Train on some pairs with the settings, text and seed of a plan."""
    return train(
        pairs,
        plan.settings,
        plan.training,
        bank=plan.bank,
        seed=plan.seed,
        resume=resume,
        watch=watch,
    )


def calibration_of(plan: TrainingPlan, pairs: Embeddings, order: float) -> Temperatures:
    """Fit temperatures to predictions for held-out pairs of the source.

    A head is trained on three quarters of the source's objects with the same settings, from `order`
    and without a search. It predicts the last quarter, as it is and under imitated sensors
    (omnivat/training/selection.py): with plain pairs alone, a head would be as confident on a new
    sensor as on its own.

    Raises DataError if no object can be held out.
    """
    fit, held = evidence(pairs)
    settings = replace(plan.settings, order=order)
    searched = replace(plan, settings=settings, training=replace(plan.training, order_search=False))
    model, classes = _trained(searched, fit).model, settings.classes
    parts = [predicted_logits(model, pairs, modalities=plan.training.given) for pairs in held]
    labels = [label_map(classes, pairs.header.classes)[pairs.label] for pairs in held]
    logits = {name: torch.cat([part[name] for part in parts]) for name in parts[0]}
    truth = torch.from_numpy(np.concatenate(labels))
    return fit_calibration(logits, truth, fusion=settings.fusion)


def _provenance(plan: TrainingPlan) -> dict[str, Any]:
    """Return the provenance of a head of the plan, for the head folder."""
    header, bank = plan.embeddings.header, plan.bank
    way = header.tac_way.get(plan.source, "")
    return {
        "source": plan.source,
        **({"tac_way": {plan.source: way}} if way else {}),
        "part": plan.part,
        "simulated": header.simulated,
        "data": header.origin,
        "pairs": len(plan.rows),
        "left_out": plan.left_out,
        "seed": plan.seed,
        "train": asdict(plan.training),
        "lang": {"origin": bank.origin, "hash": bank.hash} if bank else None,
        "versions": {
            "python": platform.python_version(),
            **{name: version(name) for name in PACKAGES},
        },
    }
