"""What training reads: labels, the share held out, and batches of cached embeddings."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from omnivat.data.splits import hold_out
from omnivat.data.store import Embeddings
from omnivat.errors import DataError
from omnivat.lang.bank import LangBank
from omnivat.model.settings import HeadSettings
from omnivat.seeding import derive_seed
from omnivat.train.settings import TrainSettings

Array = np.ndarray[Any, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Batch:
    """One batch, as `OmniVaT.training_pass` takes it."""

    vis: Tensor | None
    tac: Tensor | None
    lang: Tensor | None
    labels: Tensor
    lang_on: Tensor
    token_on: Tensor


def labels_of(source: Embeddings, head: HeadSettings) -> Array:
    """Return indices into head.classes of the source's pairs.

    Raises DataError when the source is empty, has one class, or a class that the head lacks.
    """
    if not len(source):
        raise DataError("The source domain has no training pairs.")
    names = source.header.classes
    lookup = np.array([head.classes.index(n) if n in head.classes else -1 for n in names])
    labels: Array = lookup[source.label]
    if (labels < 0).any():
        lacking = names[int(source.label[labels < 0][0])]
        raise DataError(f"The source has pairs of '{lacking}', which the head does not know.")
    if len(np.unique(labels)) < 2:
        raise DataError("The source domain has pairs of one class only; two or more are needed.")
    return labels


def held_out(
    source: Embeddings, labels: Array, settings: TrainSettings, seed: int
) -> tuple[Array, Array]:
    """Return indices of pairs to fit and of pairs held out for selection, whole objects each."""
    everything = np.arange(len(source))
    if settings.selection == "last" or settings.val_fraction == 0:
        return everything, everything[:0]
    held = hold_out(
        source.rows["object"], labels, settings.val_fraction, seed=derive_seed(seed, "hold-out")
    )
    return everything[~held], everything[held]


def batches(
    source: Embeddings,
    labels: Array,
    fit: Array,
    bank: LangBank | None,
    settings: TrainSettings,
    seed: int,
) -> Iterator[Batch]:
    """Yield one epoch: shuffled pairs, each half mirrored or not, a random style of text each."""
    random = np.random.default_rng(seed)
    shuffled = fit[random.permutation(len(fit))]
    for start in range(0, len(shuffled), settings.batch):
        rows = shuffled[start : start + settings.batch]
        truth = labels[rows]
        lang = None
        if bank is not None and settings.lang:
            styles = random.integers(bank.embeddings.shape[1], size=len(rows))
            lang = torch.from_numpy(bank.embeddings[truth, styles])
        images = {
            name: _mirrored(getattr(source, name), getattr(source, f"{name}_flip"), rows, random)
            for name in settings.given
        }
        yield Batch(
            vis=images.get("vis"),
            tac=images.get("tac"),
            lang=lang,
            labels=torch.from_numpy(truth),
            lang_on=torch.from_numpy(random.random(len(rows)) >= settings.lang_drop),
            token_on=torch.from_numpy(random.random(len(rows)) >= settings.class_token_drop),
        )


def _mirrored(
    plain: Array, flipped: Array | None, rows: Array, random: np.random.Generator
) -> Tensor:
    """Return embeddings of the rows, each of the mirrored image with probability a half."""
    chosen = np.asarray(plain[rows], dtype=np.float32)
    if flipped is not None:
        mirror = random.random(len(rows)) < 0.5
        chosen[mirror] = flipped[rows[mirror]]
    return torch.from_numpy(chosen)
