"""Train a head on the embeddings of one domain. No other domain is used here."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.head.head import OmniVaT
from omnivat.head.settings import HeadSettings
from omnivat.kit.progress import OnStep, ignore
from omnivat.kit.seeding import derive_seed
from omnivat.kit.threads import LIGHT, one_thread
from omnivat.training.batches import held_out, labels_of
from omnivat.training.loop import Trained, Watch, steps_of, train_once
from omnivat.training.order_search import search_order, search_steps
from omnivat.training.settings import TrainSettings

TEACHER = TrainSettings(epochs=120)  # its epochs, batch and rate serve every teacher
AFTER = 0.1  # factor of p's rate after a search: little remains to be found


def train(
    source: Embeddings,
    head: HeadSettings,
    settings: TrainSettings,
    *,
    bank: LangBank | None = None,
    seed: int = 0,
    resume: Path | None = None,
    on_step: OnStep = ignore,
    watch: Watch | None = None,
) -> Trained:
    """Train a head on the pairs of one source domain.

    source   training pairs of one domain; their labels index header.classes, and head.classes must
             be the classes present
    bank     LANG for those classes, or None to train without text
    seed     seed of all random streams: same seed and machine, same weights
    resume   file for the state after each epoch. A stopped training resumes from it; the final
             weights are identical to the bit. The file is removed at the end
    on_step  called at every optimiser step, including those of an order search
    watch    more callbacks, instead of `on_step`

    If settings.order_draw draws orders, the model's own order keeps its initial value. With
    settings.order_teachers, heads with p held at evenly spaced orders are trained first, with LANG
    if there is any; this head then learns their mean logits, without LANG.

    Raises DataError if there is nothing to learn, if `resume` belongs to another training, or if
    `bank` belongs to another checkpoint than the images; OmniVatError if the loss is not finite;
    TrainingCancelled if the watch stops it.

    >>> from omnivat import HeadSettings, default_embeddings, load_embeddings
    >>> source = load_embeddings(default_embeddings()).in_domain("TAG-sim", split="train")
    >>> head = HeadSettings(input_width=source.width, classes=source.header.classes, width=16)
    >>> trained = train(source, head, TrainSettings(epochs=2))
    >>> [round(epoch["loss"], 1) > 0 for epoch in trained.epochs]
    [True, True]
    """
    watch = watch or Watch(on_step=on_step)
    if settings.order_draw != "none":
        head = replace(head, learn_order=False)  # p is drawn, so it is not learned
    if bank is not None:
        bank.is_of(source.header)  # raises an error for texts of another checkpoint
    with one_thread(head.width <= LIGHT):
        search: dict[str, Any] = {}
        # it keeps no state: a resumed training finds the same order again
        if settings.order_search:
            part = source.select(held_out(source, labels_of(source, head), settings, seed)[0])
            first = search_steps(head, settings)
            whole = first + settings.epochs * steps_of(len(part), settings)
            search = search_order(
                part, head, settings, seed=seed, watch=watch.part(0, whole).steps_only()
            )
            watch = watch.part(first, whole)
            head = replace(head, order=search["start"])
            settings = replace(settings, order_lr_scale=AFTER * settings.order_lr_scale)
        teachers: list[OmniVaT] = []
        if settings.order_teachers:
            teachers, watch = _teachers(source, head, settings, bank, seed, watch)
            settings, bank = replace(settings, lang=False), None  # LANG was for the teachers
        trained = train_once(
            source,
            head,
            settings,
            bank=bank,
            seed=seed,
            resume=resume,
            watch=watch,
            teachers=teachers,
        )
    return replace(trained, search={**search, "found": trained.model.order} if search else {})


def _teachers(
    source: Embeddings,
    head: HeadSettings,
    settings: TrainSettings,
    bank: LangBank | None,
    seed: int,
    watch: Watch,
) -> tuple[list[OmniVaT], Watch]:
    """Return heads with p held at evenly spaced orders of [0, 1], and the watch of the rest.

    They keep no state: a resumed training makes the same teachers again.
    """
    count = settings.order_teachers
    own = replace(settings, batch=TEACHER.batch, lr=TEACHER.lr, order_draw="none", order_teachers=0)
    own = replace(own, epochs=min(settings.epochs, TEACHER.epochs))
    orders = [k / (count - 1) for k in range(count)] if count > 1 else [head.order]
    pairs = len(held_out(source, labels_of(source, head), settings, seed)[0])
    each = own.epochs * steps_of(pairs, own)
    whole = count * each + settings.epochs * steps_of(pairs, settings)
    made = []
    for k, order in enumerate(orders):
        part, one = watch.part(k * each, whole).steps_only(), derive_seed(seed, "teacher", k)
        held = replace(head, order=order)
        made.append(
            train_once(source, held, own, bank=bank, seed=one, resume=None, watch=part).model
        )
    return made, watch.part(count * each, whole)
