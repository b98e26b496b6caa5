"""The plan of a training, checked before its first step."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import DEFAULT_BANK, LangBank, load_bank
from omnivat.head.checkpoint import Head
from omnivat.head.settings import HeadSettings
from omnivat.kit.config import settings_from
from omnivat.kit.errors import DataError
from omnivat.training.settings import TrainSettings
from omnivat.training.state import run_name

FROM_DATA = ("classes", "input_width", "lang_width")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingPlan:
    """Pairs, settings, text and seed of one training. It holds no copy of the pairs."""

    embeddings: Embeddings  # the whole set; only `rows` are used for training
    source: str
    part: str
    rows: NDArray[np.int64]  # training pairs of the source, those with a class
    settings: HeadSettings
    training: TrainSettings
    bank: LangBank | None
    seed: int
    left_out: int  # training pairs of the source without a class

    def at(self, order: float, seed: int) -> "TrainingPlan":
        """Return the same plan with p fixed at `order`, and another seed."""
        settings = replace(self.settings, order=order, learn_order=False)
        training = replace(self.training, order_search=False, order_draw=False, order_teachers=0)
        return replace(self, settings=settings, training=training, seed=seed)

    @property
    def pairs(self) -> Embeddings:
        """A copy of the training pairs."""
        return self.embeddings.select(self.rows)

    @property
    def name(self) -> str:
        """A hash of pairs, settings, text and seed."""
        return run_name(self.pairs, self.settings, self.training, self.bank, self.seed)


def plan_training(
    embeddings: Embeddings,
    source: str,
    *,
    part: str = "",
    head: Mapping[str, Any] | None = None,
    training: TrainSettings | None = None,
    bank: LangBank | str | Path | None = None,
    seed: int = 0,
) -> TrainingPlan:
    """Plan a training on the pairs of one domain, without training.

    source    name of the domain; its split "train" is used, or all pairs without a split. Pairs
              without a class are left out
    part      only this part of it, such as "outdoor"
    head      settings of the head by name; classes and widths follow from the data
    training  None: default settings
    bank      LANG or its file; None: the project's own. Not read if training.lang is off

    Raises DataError for pairs of fewer than two classes, or if the bank lacks a class;
    SettingsError for invalid settings.

    >>> from omnivat import EXAMPLES, load_embeddings
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> light = TrainSettings(epochs=2, lang=False)
    >>> plan = plan_training(pairs, "Chirps A-sim", head={"width": 16}, training=light)
    >>> len(plan.rows), plan.settings.input_width, plan.settings.width
    (100, 64, 16)
    """
    training = training or TrainSettings()
    every = embeddings.rows_of(source, split="train", part=part)
    rows = every[embeddings.labelled[every]]
    classes = tuple(embeddings.header.classes[k] for k in np.unique(embeddings.label[rows]))
    if len(classes) < 2:
        what = f", part '{part}'," if part else ""
        raise DataError(
            f"'{source}'{what} has {len(every)} training pairs, of {len(classes)} classes; a head"
            " needs two classes or more. Choose another domain."
        )
    texts = None
    if training.lang:
        texts = (
            bank if isinstance(bank, LangBank) else load_bank(bank or DEFAULT_BANK)
        ).for_classes(classes)
    values = {
        "classes": classes,
        "input_width": embeddings.width,
        "lang_width": texts.width if texts else 1,
    }
    settings = settings_from(HeadSettings, {**values, **(head or {})})
    return TrainingPlan(
        embeddings=embeddings,
        source=source,
        part=part,
        rows=rows,
        settings=settings,
        training=training,
        bank=texts,
        seed=seed,
        left_out=len(every) - len(rows),
    )


def plan_like(
    head: Head,
    embeddings: Embeddings,
    *,
    source: str = "",
    bank: LangBank | str | Path | None = None,
) -> TrainingPlan:
    """Plan a training with the settings of a trained head.

    source  another domain to train on; "": the head's own

    Raises DataError if the embeddings have another encoder or lack the domain.
    """
    head.require_embeddings(embeddings)
    own = source in ("", head.source)
    kept = {k: v for k, v in asdict(head.settings).items() if k not in FROM_DATA}
    return plan_training(
        embeddings,
        source or head.source,
        part=str(head.provenance.get("part", "")) if own else "",
        head=kept,
        training=settings_from(TrainSettings, head.provenance.get("train", {})),
        bank=bank,
        seed=int(head.provenance.get("seed", 0)),
    )
