"""Training data: labels, and batches of cached embeddings."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from torch import Tensor

from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.head.linear_maps import SPREAD_ROWS
from omnivat.head.predict_set import label_map
from omnivat.head.settings import HeadSettings
from omnivat.kit.errors import DataError
from omnivat.training.settings import DRAWN, TrainSettings

Array = np.ndarray[Any, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Batch:
    """One batch for `omnivat.head.training.training_pass`."""

    images: dict[str, Tensor]
    lang: Tensor | None
    labels: Tensor
    lang_on: Tensor
    token_on: Tensor
    order: Tensor | None = None  # (B,) if orders are drawn

    def to(self, device: torch.device) -> "Batch":
        """Return the batch on a device."""
        images = {name: rows.to(device) for name, rows in self.images.items()}
        rest = {name: getattr(self, name) for name in self.__slots__ if name != "images"}
        moved = {name: value.to(device) for name, value in rest.items() if value is not None}
        return replace(self, images=images, **moved)


def labels_of(source: Embeddings, head: HeadSettings) -> Array:
    """Return the class indices of the source's pairs in head.classes.

    Raises DataError if the source is empty, has one class, or has a class that the head lacks.
    """
    if not len(source):
        raise DataError("The source domain has no training pairs.")
    names = source.header.classes
    labels: Array = label_map(head.classes, names)[source.label]
    if (labels < 0).any():
        lacking = names[int(source.label[labels < 0][0])]
        raise DataError(f"The source has pairs of '{lacking}', which the head lacks.")
    if len(np.unique(labels)) < 2:
        raise DataError("The source domain has pairs of one class only; two or more are needed.")
    return labels


def batches(
    source: Embeddings, labels: Array, bank: LangBank | None, settings: TrainSettings, seed: int
) -> Iterator[Batch]:
    """Yield the batches of one epoch: shuffled pairs, random mirroring, a random text style."""
    random = np.random.default_rng(seed)
    count = len(source)
    shuffled = random.permutation(count)
    truth = labels[shuffled]
    lang_on = torch.from_numpy(random.random(count) >= settings.lang_drop)
    token_on = torch.from_numpy(random.random(count) >= settings.class_token_drop)
    flips = {n: getattr(source, f"{n}_flip") for n in settings.given}
    mirrored = {n: random.random(count) < 0.5 for n in flips if flips[n] is not None}
    noise: dict[str, Array] = {}  # standard deviation of each channel
    if settings.noise:
        noise = {
            n: settings.noise * getattr(source, n).std(0, dtype=np.float32) for n in settings.given
        }
    spread = _spread(source, settings, random)
    lang = orders = None
    if bank is not None and settings.lang:  # a random style for every pair
        styles = random.integers(bank.embeddings.shape[1], size=count)
    targets = torch.from_numpy(truth)
    if settings.order_draw:
        orders = torch.from_numpy(random.uniform(*DRAWN, count))
    for start in range(0, count, settings.batch):
        rows = slice(start, start + settings.batch)
        images, index = {}, shuffled[rows]
        for name in settings.given:
            some = getattr(source, name)[index].astype(np.float32, copy=False)
            if name in mirrored:
                mirror = mirrored[name][rows]
                some[mirror] = flips[name][index[mirror]]
            some = _disturbed(some, noise.get(name), spread.get(name), random)
            images[name] = torch.from_numpy(some)
        if bank is not None and settings.lang:
            text = bank.embeddings[truth[rows], styles[rows]]
            lang = torch.from_numpy(text.astype(np.float32, copy=False))
        yield Batch(
            images=images,
            lang=lang,
            labels=targets[rows],
            lang_on=lang_on[rows],
            token_on=token_on[rows],
            order=None if orders is None else orders[rows],
        )


def _spread(
    source: Embeddings, settings: TrainSettings, random: np.random.Generator
) -> dict[str, Array]:
    """Return centred rows (M, input_width) by modality whose random sums are offsets; {} without.

    Their covariance is that of the source's pairs times shift², so an offset moves a batch along
    the directions in which pairs differ, as an unknown sensor does.
    """
    if not settings.shift:
        return {}
    some = random.permutation(len(source))[:SPREAD_ROWS]
    rows = {name: getattr(source, name)[some].astype(np.float32) for name in settings.given}
    scale = np.float32(settings.shift / len(some) ** 0.5)
    return {name: scale * (values - values.mean(0)) for name, values in rows.items()}


def _disturbed(
    rows: Array, noise: Array | None, spread: Array | None, random: np.random.Generator
) -> Array:
    """Return rows (B, input_width) with white noise on every channel, and moved by one random
    offset.
    """
    if noise is not None:
        rows = rows + noise * random.standard_normal(rows.shape, dtype=np.float32)
    if spread is not None:
        rows = rows + random.standard_normal(len(spread), dtype=np.float32) @ spread
    return rows
