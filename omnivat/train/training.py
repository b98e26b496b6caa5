"""Train a head on one domain's embeddings. Nothing here ever sees another domain."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from omnivat.data.store import Embeddings
from omnivat.files import write_json
from omnivat.lang.bank import LangBank
from omnivat.model.settings import HeadSettings
from omnivat.progress import OnStep, ignore
from omnivat.threads import LIGHT, one_thread
from omnivat.train.batches import held_out, labels_of
from omnivat.train.loop import Trained, steps_of, train_once
from omnivat.train.order_search import search_order, search_steps
from omnivat.train.settings import TrainSettings
from omnivat.train.state import run_name
from omnivat.train.watch import Watch

SEARCH = "order_search.json"  # beside the state of a training that may be resumed
AFTER = 0.1  # share of p's rate after a search: what is left to find is small


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

    source   training pairs of one domain; their labels index header.classes, of which
             head.classes must be the ones present
    bank     LANG for those classes, or None to train without text
    seed     everything random derives from it: same seed, same machine, same weights
    resume   file for the state after each epoch; a training that stopped resumes from it, and the
             final weights are identical to the bit. Removed at the end
    on_step  gets every optimiser step, those of a search for the order included
    watch    more callbacks, in place of `on_step`

    Where settings.order_draw draws orders, the model's own order stays where `head` states it.

    Raises DataError when there is nothing to learn, `resume` is of another training or `bank` of
    another checkpoint than the images,
    OmniVatError when the loss is not finite, TrainingCancelled when the watch stops it.
    """
    watch = watch or Watch(on_step=on_step)
    if settings.order_draw != "none":
        head = replace(head, learn_order=False)  # every p is drawn, so none is learned
    if bank is not None:
        bank.is_of(source.header)  # refuses the texts of another checkpoint
    with one_thread(head.width <= LIGHT):
        search: dict[str, Any] = {}
        if settings.order_search:
            search, watch = _searched(source, head, settings, bank, seed, resume, watch)
            head = replace(head, order=search["start"])
            settings = replace(settings, order_lr_scale=AFTER * settings.order_lr_scale)
        trained = train_once(
            source, head, settings, bank=bank, seed=seed, resume=resume, watch=watch
        )
    if resume:
        resume.with_name(SEARCH).unlink(missing_ok=True)
    if search:
        search = {**search, "found": trained.model.order}
    return replace(trained, search=search)


def _searched(
    source: Embeddings,
    head: HeadSettings,
    settings: TrainSettings,
    bank: LangBank | None,
    seed: int,
    resume: Path | None,
    watch: Watch,
) -> tuple[dict[str, Any], Watch]:
    """Return the record of the search for the order, and the watch of what follows."""
    file = resume.with_name(SEARCH) if resume else None
    run = run_name(source, head, settings, bank, seed) if file else ""
    if file and file.is_file():
        kept = json.loads(file.read_text(encoding="utf-8"))
        if kept.pop("run", "") == run:
            return kept, watch
    fit, _ = held_out(source, labels_of(source, head), settings, seed)
    part = source.select(fit)
    first = search_steps(len(part), settings)
    whole = first + settings.epochs * steps_of(len(part), settings)
    within = watch.part(0, whole).steps_only()
    found = search_order(part, head, settings, bank=bank, seed=seed, watch=within)
    if file:
        write_json(file, {"run": run, **found})
    return found, watch.part(first, whole)
