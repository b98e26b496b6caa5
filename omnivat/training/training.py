"""Train a head on the embeddings of one domain. No other domain is used here."""

import math
from collections import defaultdict
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from omnivat.data.profile import Profile, profile_of
from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.head.head import OmniVaT, build_head
from omnivat.head.settings import HeadSettings
from omnivat.kit.devices import current
from omnivat.kit.seeding import derive_seed
from omnivat.kit.threads import LIGHT, one_thread
from omnivat.training.batches import batches, labels_of
from omnivat.training.order_search import search_order, search_steps
from omnivat.training.settings import TrainSettings
from omnivat.training.state import load_state, run_name, save_state
from omnivat.training.steps import learn, make_optimiser, set_rate
from omnivat.training.watch import UNWATCHED, Watch

TEACHER = TrainSettings(epochs=120)  # its epochs, batch and rate serve every teacher
AFTER = 0.1  # factor of p's rate after a search: little remains to be found


@dataclass(frozen=True, slots=True, kw_only=True)
class Trained:
    """A trained model and the record of its training."""

    model: OmniVaT
    profile: Profile  # of the pairs
    epochs: list[dict[str, float]] = field(default_factory=list)
    search: dict[str, Any] = field(default_factory=dict)  # of the order; see `order_search`


def train(
    source: Embeddings,
    head: HeadSettings,
    settings: TrainSettings,
    *,
    bank: LangBank | None = None,
    seed: int = 0,
    resume: str | Path | None = None,
    watch: Watch = UNWATCHED,
) -> Trained:
    """Train a head on the pairs of one source domain.

    source   training pairs of one domain; their labels index header.classes, and head.classes must
             be the classes present
    bank     LANG for those classes, or None to train without text
    seed     seed of all random streams: same seed and machine, same weights
    resume   file for the state after each epoch. A stopped training resumes from it; the final
             weights are identical to the bit. The file is removed at the end
    watch    callbacks; steps are those of the optimiser and of an order search

    If settings.order_draw draws orders, the model's own order keeps its initial value. With
    settings.order_teachers, heads with p held at evenly spaced orders are trained first, with LANG
    if there is any; this head then learns their mean logits, without LANG.

    Raises DataError if there is nothing to learn, if `resume` belongs to another training, or if
    `bank` belongs to another checkpoint than the images; OmniVatError if the loss is not finite.

    >>> from omnivat import HeadSettings, default_embeddings, load_embeddings
    >>> source = load_embeddings(default_embeddings()).in_domain("TAG-sim", split="train")
    >>> head = HeadSettings(input_width=source.width, classes=source.header.classes, width=16)
    >>> trained = train(source, head, TrainSettings(epochs=2))
    >>> [round(epoch["loss"], 1) > 0 for epoch in trained.epochs]
    [True, True]
    """
    resume = Path(resume) if resume else None
    if settings.order_draw:
        head = replace(head, learn_order=False)  # p is drawn, so it is not learned
    if bank is not None:
        bank.is_of(source.header)  # raises an error for texts of another checkpoint
    labels = labels_of(source, head)
    with one_thread(head.width <= LIGHT):
        # what comes first keeps no state: a resumed training makes it again
        steps, count = steps_of(len(source), settings), settings.order_teachers
        teacher = replace(
            settings,
            epochs=min(settings.epochs, TEACHER.epochs),
            batch=TEACHER.batch,
            lr=TEACHER.lr,
            order_draw=False,
            order_teachers=0,
        )
        each = teacher.epochs * steps_of(len(source), teacher)
        first = search_steps(head) if settings.order_search else count * each
        whole = first + steps * settings.epochs
        search: dict[str, Any] = {}
        if settings.order_search:
            part = watch.part(0, whole)
            search = search_order(source, head, settings, seed=seed, watch=part)
            head = replace(head, order=search["start"])
            settings = replace(settings, order_lr_scale=AFTER * settings.order_lr_scale)
        teachers = []
        for k in range(count):
            order = k / (count - 1) if count > 1 else head.order
            made = train(
                source,
                replace(head, order=order),
                teacher,
                bank=bank,
                seed=derive_seed(seed, "teacher", k),
                watch=watch.part(k * each, whole).steps_only(),
            )
            teachers.append(made.model.to(current()))
        if teachers:
            settings, bank = replace(settings, lang=False), None  # LANG was for the teachers
        if first:
            watch = watch.part(first, whole)

        model = build_head(head, seed=derive_seed(seed, "weights"))
        profile = profile_of(source, modalities=settings.given)
        if head.standardize:
            model.standardize_by(profile)
        model = model.train().to(current())
        optimiser, run = make_optimiser(model, settings), ""
        epochs: list[dict[str, float]] = []
        if resume:
            run = run_name(source, head, settings, bank, seed)
            epochs = load_state(resume, run, model, optimiser)
        for epoch in range(len(epochs), settings.epochs):
            sums: dict[str, float] = defaultdict(float)
            drawn = batches(source, labels, bank, settings, derive_seed(seed, "epoch", epoch))
            for step, batch in enumerate(drawn):
                set_rate(optimiser, settings, (epoch * steps + step) / steps, 1 / steps)
                losses = learn(model, optimiser, batch.to(current()), settings, teachers)
                for name, value in losses.items():
                    sums[name] += value / steps
                done, text = epoch * steps + step + 1, f"epoch {epoch + 1} of {settings.epochs}"
                loss = f", loss {losses['loss']:.3f}"
                watch.step(done, steps * settings.epochs, text + loss)
            record = {"epoch": float(epoch), **sums, "order": model.order}
            if head.order_per_modality:
                record |= {f"order_{name}": order for name, order in model.orders.items()}
            epochs.append(record)
            watch.on_epoch(record, model)
            if resume:
                save_state(resume, run, model, optimiser, epochs)
    if resume:
        resume.unlink(missing_ok=True)
    if search:
        search["found"] = model.order
    return Trained(model=model.eval().cpu(), profile=profile, epochs=epochs, search=search)


def steps_of(pairs: int, settings: TrainSettings) -> int:
    """Return the number of steps in an epoch of this many pairs."""
    return math.ceil(pairs / settings.batch)
