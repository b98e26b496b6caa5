"""Choices made on held-out objects of a source, the training pairs of a run as arrays, and results."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import nll_loss

from omnivat.baselines.contract import Source
from omnivat.baselines.evidence import folds
from omnivat.calibration import fit_calibration, fit_temperature
from omnivat.data.store import Embeddings
from omnivat.errors import DataError
from omnivat.evaluate import label_map
from omnivat.lang.bank import LangBank
from omnivat.lang.clip_prompts import load_prompts
from omnivat.model.fusion import FUSIONS, Calibration, fused_logs
from omnivat.protocol.images import live_of
from omnivat.protocol.settings import Task
from omnivat.seeding import derive_seed
from omnivat.selection import Evidence, evidence_of


def source_arrays(found: Task, bank: LangBank | None, seed: int, pairs: Embeddings | None = None) -> Source:
    """Return training pairs as arrays for baselines; `pairs` None: all of the task.

    A LANG bank that lacks a class is left out; `why_no_lang` has the reason.
    """
    pairs = found.train if pairs is None else pairs
    labels = label_map(found.classes, pairs.header.classes)[pairs.label]
    texts, why = None, "No LANG bank is used."
    if bank is not None:
        try:
            texts = bank.for_classes(found.classes)
        except DataError as error:
            why = str(error)
    live, why_not_live = None, ""
    try:
        live = live_of(pairs)
    except DataError as error:
        why_not_live = str(error)
    return Source(
        vis=tensor(pairs.vis),
        tac=tensor(pairs.tac),
        vis_flip=None if pairs.vis_flip is None else tensor(pairs.vis_flip),
        tac_flip=None if pairs.tac_flip is None else tensor(pairs.tac_flip),
        labels=torch.from_numpy(labels),
        objects=tuple(pairs.rows["object"]),
        classes=found.classes,
        lang=None if texts is None else tensor(texts.embeddings),
        lang_of_images=texts is not None and texts.is_of(pairs.header),
        why_no_lang="" if texts is not None else why,
        plain=None if texts is None or texts.plain is None else tensor(texts.plain),
        logit_scale=None if texts is None else texts.logit_scale,
        prompts=None if texts is None or not texts.text_hash else partial(load_prompts, texts.encoder, texts.text_hash),
        live=live,
        why_not_live=why_not_live,
        seed=derive_seed(seed, "baselines", found.setting.source.domain),
    )


def fold_of(found: Task, seed: int) -> Evidence | None:
    """Return the first fold of the baselines; None if no object can be held out."""
    splits = folds(source_arrays(found, None, seed), 1)
    if not splits:
        return None
    held = np.zeros(len(found.train), dtype=bool)
    held[splits[0][1].numpy()] = True
    return evidence_of(found.train, held, derive_seed(seed, "imitated sensors"))


def tensor(array: Any) -> Tensor:
    """Return a float32 copy as a tensor."""
    return torch.from_numpy(np.array(array, dtype=np.float32))


Logits = Callable[[Embeddings], dict[str, Tensor]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """Choices made on held-out objects of a source: once for each source, for all seeds.

    candidate    name of the head's settings among `Method.candidates`
    fusion       late fusion that held-out pairs favour; "fused" remains the method's own fusion
    calibration  temperatures, and the share of a learned fusion
    losses       held-out log loss of each candidate
    settled      names of the candidates that a baseline chose
    """

    candidate: str = ""
    fusion: str = "mean"
    calibration: Calibration = field(default_factory=Calibration)
    losses: Mapping[str, float] = field(default_factory=dict)
    settled: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """A fitted method, and the contents of its record.

    logits       pairs -> reading -> logits or log-probabilities (N, K) before any temperature:
                 "fused", "vis", "tac" and, of a head, "vis_branch", "tac_branch" and "pair"
    features     pairs -> "vis", "tac" and "pair" -> (N, W), the last features before classification
    choice       choices made on held-out objects
    separate     readings for late fusion; empty if the method fuses features
    """

    logits: Logits
    features: Logits
    choice: Choice
    separate: tuple[str, str] | None
    chosen: dict[str, Any] = field(default_factory=dict)
    parameters: int = 0
    guard: dict[str, float] | None = None


def choice_record(choice: Choice) -> dict[str, Any]:
    """Return a choice for the record."""
    found: dict[str, Any] = {"fusion": choice.fusion}
    if choice.losses:
        found |= {"settings": choice.candidate, "held-out log loss": dict(choice.losses)}
    return found


def chosen_fusion(logits: Mapping[str, Tensor], labels: Tensor) -> str:
    """Return the late fusion with the lowest log loss on held-out pairs, each at its own temperature.

    logits  as for `fit_calibration`; fusion needs two branches
    """
    if "vis_branch" not in logits:
        return "mean"
    share = fit_calibration(logits, labels).share

    def loss(kind: str) -> float:
        mixed = with_fused(logits, kind, share)["fused"]
        tempered_logs = torch.log_softmax(mixed / fit_temperature(mixed, labels), dim=-1)
        return round(float(nll_loss(tempered_logs, labels)), 9)

    return min((k for k in FUSIONS if k != "feature" or "pair" in logits), key=loss)


def with_fused(logits: Mapping[str, Tensor], fusion: str, share: float = 0.5) -> dict[str, Tensor]:
    """Add "fused": the fused branches, or the only modality."""
    if "vis_branch" not in logits:
        return {**logits, "fused": next(iter(logits.values()))}
    if fusion == "feature":
        return {**logits, "fused": logits["pair"]}
    branches = logits["vis_branch"], logits["tac_branch"]
    return {**logits, "fused": fused_logs(fusion, *branches, share)}
