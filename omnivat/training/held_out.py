"""Predictions for held-out source pairs, and the calibration fitted to them.

One fold: a quarter of the source's objects is held out, and a head is trained on the rest with the
same settings. It predicts the held-out pairs as they are and under imitated sensors
(omnivat/training/selection.py). With plain pairs alone, a head would be as confident on a new
sensor as on
its own."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import torch
from torch import Tensor

from omnivat.data.arrays import copied
from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.head.calibration import fit_calibration
from omnivat.head.fusion import Calibration, fuse
from omnivat.head.head import OmniVaT
from omnivat.head.settings import HeadSettings
from omnivat.head.training import training_pass
from omnivat.kit.errors import DataError
from omnivat.kit.seeding import derive_seed
from omnivat.kit.stages import IMAGES
from omnivat.measure.evaluate import CHUNK, label_map, predicted_logits, predicted_probabilities
from omnivat.measure.gaps.confusion import accuracy
from omnivat.training import TrainSettings, Watch, train
from omnivat.training.selection import Evidence, evidence

FOLD = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class HeldOut:
    """Logits by reading, and labels, of held-out pairs."""

    logits: dict[str, Tensor]  # (N, K) each, before any temperature
    labels: Tensor  # (N,)


def held_out_logits(
    fold: Evidence, classes: Sequence[str], logits: Callable[[Embeddings], Mapping[str, Tensor]]
) -> HeldOut:
    """Return a method's logits on the held-out pairs of a fold, plain and under imitated
    sensors.
    """
    parts = [logits(pairs) for pairs in fold.held.values()]
    labels = [label_map(classes, pairs.header.classes)[pairs.label] for pairs in fold.held.values()]
    return HeldOut(
        logits={name: torch.cat([part[name] for part in parts]) for name in parts[0]},
        labels=torch.from_numpy(np.concatenate(labels)),
    )


def calibration_of(
    source: Embeddings,
    head: HeadSettings,
    settings: TrainSettings,
    *,
    bank: LangBank | None = None,
    seed: int = 0,
    watch: Watch | None = None,
) -> Calibration:
    """Train once on three quarters of the source's objects and fit to the last quarter.

    Arguments as for `omnivat.training.train`.
    Raises DataError if no object can be held out.
    """
    fold = evidence(source, FOLD)
    trained = train(fold.fit, head, settings, bank=bank, seed=seed, watch=watch)
    logits = partial(predicted_logits, trained.model, modalities=settings.given)
    found = held_out_logits(fold, head.classes, logits)
    return fit_calibration(found.logits, found.labels, fusion=head.fusion)


def lang_guard(
    model: OmniVaT, pairs: Embeddings, bank: LangBank, *, seed: int = 0
) -> dict[str, float]:
    """Return ACC on pairs "with" the text of their class, "without" it, and the "gap".

    pairs  test pairs of the source; classes that the head lacks are left out
    bank   LANG of the head's classes; each pair gets a random style of its class
    Raises DataError if there are no pairs.
    """
    labels = label_map(model.settings.classes, pairs.header.classes)[pairs.label]
    known = np.flatnonzero(labels >= 0)
    if not len(known):
        raise DataError("The LANG guard needs pairs of the head's classes; there are none.")
    pairs, truth = pairs.select(known), torch.from_numpy(labels[known])
    random = np.random.default_rng(derive_seed(seed, "guard"))
    styles = random.integers(bank.embeddings.shape[1], size=len(truth))
    texts = torch.from_numpy(bank.embeddings[truth.numpy(), styles])
    guided = guided_probabilities(model, pairs, texts, truth)
    plain = predicted_probabilities(model, pairs)["fused"]
    found = {
        "with": float(accuracy(truth, guided.argmax(-1))),
        "without": float(accuracy(truth, plain.argmax(-1))),
    }
    return found | {"gap": found["with"] - found["without"]}


@torch.no_grad()
def guided_probabilities(
    model: OmniVaT, pairs: Embeddings, texts: Tensor, labels: Tensor
) -> Tensor:
    """Return fused probabilities (N, K) of pairs guided by texts (N, lang_width), as in training.

    labels  (N,) not used by the head: class tokens are the class-agnostic ones
    """
    found = []
    for rows in torch.arange(len(pairs)).split(CHUNK):
        images = {n: torch.from_numpy(copied(getattr(pairs, n)[rows.numpy()])) for n in IMAGES}
        on = torch.ones(len(rows), dtype=torch.bool)
        output = training_pass(
            model, images, texts[rows].to(model.dtype), labels[rows], lang_on=on, token_on=~on
        )
        found.append(fuse("mean", output.logits, None, model.calibration))
    return torch.cat(found)
