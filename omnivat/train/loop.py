"""Train a head on one domain's embeddings. Nothing here ever sees another domain."""

import math
from dataclasses import dataclass, field
from pathlib import Path

import torch

from omnivat.data.store import Embeddings
from omnivat.evaluate import predicted_probabilities
from omnivat.gaps.confusion import macro_f1
from omnivat.lang.bank import LangBank
from omnivat.model.head import OmniVaT, build_head
from omnivat.model.settings import HeadSettings
from omnivat.progress import OnStep, Step, ignore
from omnivat.seeding import derive_seed
from omnivat.threads import LIGHT, one_thread
from omnivat.train.batches import Array, batches, held_out, labels_of
from omnivat.train.settings import TrainSettings
from omnivat.train.state import Progress, load_state, run_name, save_state
from omnivat.train.steps import learn, make_optimiser, set_rate


@dataclass(frozen=True, slots=True, kw_only=True)
class Trained:
    """A trained model and the record of its training."""

    model: OmniVaT
    epochs: list[dict[str, float]] = field(default_factory=list)
    chosen_epoch: int = 0


def train(
    source: Embeddings,
    head: HeadSettings,
    settings: TrainSettings,
    *,
    bank: LangBank | None = None,
    seed: int = 0,
    resume: Path | None = None,
    on_step: OnStep = ignore,
) -> Trained:
    """Train a head on the pairs of one source domain.

    source  training pairs of one domain; their labels index header.classes, of which head.classes
            must be the ones present
    bank    LANG for those classes, or None to train without text
    seed    everything random derives from it: same seed, same machine, same weights
    resume  file for the state after each epoch; where it exists already, training goes on from it
            to the same weights, to the bit. Removed at the end

    Raises DataError when there is nothing to learn or `resume` is of another training,
    OmniVatError when the loss is not finite.
    """
    with one_thread(head.width <= LIGHT):
        return _train(source, head, settings, bank, seed, resume, on_step)


def _train(
    source: Embeddings,
    head: HeadSettings,
    settings: TrainSettings,
    bank: LangBank | None,
    seed: int,
    resume: Path | None,
    on_step: OnStep,
) -> Trained:
    labels = labels_of(source, head)
    fit, held = held_out(source, labels, settings, seed)
    model = build_head(head, seed=derive_seed(seed, "weights")).train()
    optimiser = make_optimiser(model, settings)
    run = run_name(source, head, settings, bank, seed) if resume else ""
    progress = load_state(resume, run, model, optimiser) if resume else Progress()
    steps = math.ceil(len(fit) / settings.batch)
    for epoch in range(len(progress.epochs), settings.epochs):
        sums: dict[str, float] = {}
        stream = derive_seed(seed, "epoch", epoch)
        for step, batch in enumerate(batches(source, labels, fit, bank, settings, stream)):
            set_rate(optimiser, settings, (epoch * steps + step) / steps, 1 / steps)
            losses = learn(model, optimiser, batch, settings)
            for name, value in losses.items():
                sums[name] = sums.get(name, 0.0) + value / steps
            done = epoch * steps + step + 1
            on_step(
                Step(done=done, total=steps * settings.epochs, text=f"loss {losses['loss']:.3f}")
            )
        record = {"epoch": float(epoch), **sums, **_orders(model)}
        if len(held):
            score = _source_score(model, source.select(held), labels[held], settings)
            record["source_val_macro_f1"] = score
            if score > progress.best_score:
                progress.best_score, progress.best_epoch = score, epoch
                progress.best = {n: t.clone() for n, t in model.state_dict().items()}
        progress.epochs.append(record)
        if resume:
            save_state(resume, run, model, optimiser, progress)
    if progress.best:
        model.load_state_dict(progress.best)
    if resume:
        resume.unlink(missing_ok=True)
    chosen = progress.best_epoch if progress.best else settings.epochs - 1
    return Trained(model=model.eval(), epochs=progress.epochs, chosen_epoch=chosen)


def _orders(model: OmniVaT) -> dict[str, float]:
    """Return the learned order for the record, and that of each modality where they differ."""
    if not model.settings.order_per_modality:
        return {"order": model.order}
    return {"order": model.order, **{f"order_{n}": p for n, p in model.orders.items()}}


def _source_score(
    model: OmniVaT, held: Embeddings, labels: Array, settings: TrainSettings
) -> float:
    model.eval()
    answers = predicted_probabilities(model, held, modalities=settings.given)["fused"].argmax(-1)
    model.train()
    return float(macro_f1(torch.from_numpy(labels), answers))
