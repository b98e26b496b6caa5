"""The plan of a training, checked before its first step."""

import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import DEFAULT_BANK, LangBank, load_bank
from omnivat.head.checkpoint import Head
from omnivat.head.settings import HeadSettings
from omnivat.kit.config import settings_from
from omnivat.kit.errors import DataError
from omnivat.training import Trained, TrainSettings, Watch, train
from omnivat.training.batches import labels_of
from omnivat.training.state import run_name

PACKAGES = ("torch", "numpy", "safetensors")  # whose versions a head keeps
FROM_DATA = ("classes", "input_width", "lang_width")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainingPlan:
    """Pairs, settings, text and seed of one training."""

    embeddings: Embeddings  # the whole set; only `pairs` are used for training
    source: str
    part: str
    pairs: Embeddings  # training pairs of the source, those with a class
    settings: HeadSettings
    training: TrainSettings
    bank: LangBank | None
    seed: int
    left_out: int  # training pairs of the source without a class

    def at(self, order: float, seed: int) -> "TrainingPlan":
        """Return the same plan with p fixed at `order`, and another seed."""
        found = self.searched(order)
        settings = replace(found.settings, learn_order=False)
        training = replace(found.training, order_draw=False, order_teachers=0)
        return replace(self, settings=settings, training=training, seed=seed)

    def searched(self, order: float) -> "TrainingPlan":
        """Return the same plan from an order that a search has found."""
        settings = replace(self.settings, order=order)
        return replace(self, settings=settings, training=replace(self.training, order_search=False))

    def train(self, *, watch: Watch | None = None, resume: Path | None = None) -> Trained:
        """Train; arguments and errors as in `omnivat.training.train`."""
        return train(
            self.pairs,
            self.settings,
            self.training,
            bank=self.bank,
            seed=self.seed,
            resume=resume,
            watch=watch,
        )

    @property
    def name(self) -> str:
        """A hash of pairs, settings, text and seed."""
        return run_name(self.pairs, self.settings, self.training, self.bank, self.seed)

    @property
    def encoder(self) -> dict[str, str]:
        """The encoder of the embeddings, for the head folder."""
        header = self.embeddings.header
        return {
            "name": header.encoder,
            "weights_hash": header.weights_hash,
            "preprocessing": header.preprocessing,
        }

    def provenance(self) -> dict[str, Any]:
        """Return the provenance of a head of this plan, for the head folder."""
        header, bank = self.embeddings.header, self.bank
        return {
            "source": self.source,
            "part": self.part,
            "simulated": header.simulated,
            "data": header.origin,
            "pairs": len(self.pairs),
            "left_out": self.left_out,
            "seed": self.seed,
            "train": asdict(self.training),
            "lang": {"origin": bank.origin, "hash": bank.hash} if bank else None,
            "versions": {
                "python": platform.python_version(),
                **{name: version(name) for name in PACKAGES},
            },
        }


def plan_training(
    embeddings: Embeddings,
    source: str,
    *,
    part: str = "",
    head: Mapping[str, Any] | None = None,
    training: TrainSettings | None = None,
    bank: LangBank | Path | None = None,
    seed: int = 0,
) -> TrainingPlan:
    """Plan a training on the pairs of one domain, without training.

    source    name of the domain; its split "train" is used, or all pairs without a split. Pairs
              without a class are left out
    part      only this part of it, such as "outdoor"
    head      settings of the head by name; classes and widths follow from the data
    training  None: default settings
    bank      LANG or its file; None: the project's own. Not read if training.lang is off

    Raises DataError if there is nothing to learn, or if the bank lacks a class; SettingsError for
    invalid settings.

    >>> from omnivat import EXAMPLES, load_embeddings
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> light = TrainSettings(epochs=2, lang=False)
    >>> plan = plan_training(pairs, "Chirps A-sim", head={"width": 16}, training=light)
    >>> len(plan.pairs), plan.settings.input_width, plan.settings.width
    (100, 64, 16)
    """
    training = training or TrainSettings()
    pairs = embeddings.in_domain(source, split="train", part=part)
    if not len(pairs):
        what = f" of part '{part}'" if part else ""
        raise DataError(f"'{source}' has no pairs{what} to train on; choose another domain.")
    if left_out := len(pairs) - int(pairs.labelled.sum()):
        pairs = pairs.select(pairs.labelled)
        if not len(pairs):
            raise DataError(
                f"None of the {left_out} pairs of '{source}' has a class; choose another domain."
            )
    present = set(pairs.label.tolist())
    classes = tuple(name for k, name in enumerate(embeddings.header.classes) if k in present)
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
    labels_of(pairs, settings)  # raises an error for a single class before any work
    return TrainingPlan(
        embeddings=embeddings,
        source=source,
        part=part,
        pairs=pairs,
        settings=settings,
        training=training,
        bank=texts,
        seed=seed,
        left_out=left_out,
    )


def plan_like(
    head: Head, embeddings: Embeddings, *, source: str = "", bank: LangBank | Path | None = None
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
