"""One training on the embeddings of one domain, from a seed to the final weights."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import torch

from omnivat.data.profile import profile_of
from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.head.head import OmniVaT, build_head
from omnivat.head.settings import HeadSettings
from omnivat.kit.devices import current
from omnivat.kit.errors import OmniVatError
from omnivat.kit.progress import OnStep, Step, ignore, never
from omnivat.kit.seeding import derive_seed
from omnivat.measure.evaluate import predicted_probabilities
from omnivat.measure.gaps.confusion import macro_f1
from omnivat.training.batches import Batch, batches, held_out, labels_of
from omnivat.training.settings import TrainSettings
from omnivat.training.state import Progress, load_state, run_name, save_state
from omnivat.training.steps import Momentum, learn, make_optimiser, set_rate

OnEpoch = Callable[[dict[str, float], OmniVaT], None]


class TrainingCancelled(OmniVatError):
    """The caller cancelled the training. Nothing was written."""


def _no_epoch(record: dict[str, float], model: OmniVaT) -> None: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Watch:
    """Callbacks of one training.

    on_step    called at every optimiser step
    on_epoch   called with the record of every epoch and the model, in training mode
    cancelled  called before every step; training stops when it returns True
    done       steps finished before this training
    whole      steps in total; 0 means those of this training
    """

    on_step: OnStep = ignore
    on_epoch: OnEpoch = _no_epoch
    cancelled: Callable[[], bool] = never
    done: int = 0
    whole: int = 0

    def step(self, done: int, total: int, text: str) -> None:
        """Report a step. Raises TrainingCancelled if the caller cancelled."""
        if self.cancelled():
            raise TrainingCancelled("Training was cancelled; nothing was written.")
        self.on_step(Step(done=self.done + done, total=self.whole or total, text=text))

    def part(self, done: int, whole: int) -> "Watch":
        """Return the watch for a part of a longer task, after `done` of `whole` steps."""
        return replace(self, done=done, whole=whole)

    def steps_only(self) -> "Watch":
        """Return the same watch without reports of epochs."""
        return replace(self, on_epoch=_no_epoch)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trained:
    """A trained model and the record of its training."""

    model: OmniVaT
    epochs: list[dict[str, float]] = field(default_factory=list)
    chosen_epoch: int = 0
    search: dict[str, Any] = field(default_factory=dict)  # of the order; see `order_search`


def train_once(
    source: Embeddings,
    head: HeadSettings,
    settings: TrainSettings,
    *,
    bank: LangBank | None,
    seed: int,
    resume: Path | None,
    watch: Watch,
    teachers: Sequence[OmniVaT] = (),
) -> Trained:
    """Train from the initial p in `head`; arguments and errors as in `train`.

    teachers  trained heads whose mean logits are learned, in place of the labels
    """
    labels = labels_of(source, head)
    fit, held = held_out(source, labels, settings, seed)
    model = build_head(head, seed=derive_seed(seed, "weights"))
    if head.standardize:
        model.standardize_by(profile_of(source, modalities=settings.given))
    model = model.train().to(current())
    optimiser = make_optimiser(model, settings)
    run = run_name(source, head, settings, bank, seed) if resume else ""
    progress = load_state(resume, run, model, optimiser) if resume else Progress()
    steps = steps_of(len(fit), settings)
    teachers = [teacher.eval().to(current()) for teacher in teachers]
    for epoch in range(len(progress.epochs), settings.epochs):
        stream = derive_seed(seed, "epoch", epoch)
        drawn = batches(source, labels, fit, bank, settings, stream)
        record = _epoch(model, optimiser, drawn, settings, epoch, steps, watch, teachers)
        if len(held):
            shares = predicted_probabilities(
                model.eval(), source, modalities=settings.given, rows=held
            )
            model.train()
            score = macro_f1(torch.from_numpy(labels[held]), shares["fused"].argmax(-1))
            record["source_val_macro_f1"] = float(score)
            progress.keep_best(record["source_val_macro_f1"], epoch, model)
        progress.epochs.append(record)
        watch.on_epoch(record, model)
        if resume:
            save_state(resume, run, model, optimiser, progress)
    if progress.best:
        model.load_state_dict(progress.best)
    if resume:
        resume.unlink(missing_ok=True)
    chosen = settings.epochs - 1 if progress.best_epoch is None else progress.best_epoch
    return Trained(model=model.eval().cpu(), epochs=progress.epochs, chosen_epoch=chosen)


def steps_of(pairs: int, settings: TrainSettings) -> int:
    """Return the number of steps in an epoch of this many pairs."""
    return math.ceil(pairs / settings.batch)


def _epoch(
    model: OmniVaT,
    optimiser: Momentum,
    drawn: Iterable[Batch],
    settings: TrainSettings,
    epoch: int,
    steps: int,
    watch: Watch,
    teachers: Sequence[OmniVaT],
) -> dict[str, float]:
    """Run the steps of one epoch; return its mean losses and p."""
    sums: dict[str, float] = {}
    device = model.classifier.device
    for step, batch in enumerate(on_host.to(device) for on_host in drawn):
        set_rate(optimiser, settings, (epoch * steps + step) / steps, 1 / steps)
        losses = learn(model, optimiser, batch, settings, teachers)
        for name, value in losses.items():
            sums[name] = sums.get(name, 0.0) + value / steps
        done = epoch * steps + step + 1
        text = f"epoch {epoch + 1} of {settings.epochs}, loss {losses['loss']:.3f}"
        watch.step(done, steps * settings.epochs, text)
    apart = (
        {f"order_{n}": p for n, p in model.orders.items()}
        if model.settings.order_per_modality
        else {}
    )
    return {"epoch": float(epoch), **sums, "order": model.order, **apart}
