"""The training pairs of a run as arrays, and the fold for all choices."""

from functools import partial
from typing import Any

import numpy as np
import torch
from torch import Tensor

from omnivat.baselines.contract import Source
from omnivat.baselines.evidence import folds
from omnivat.data.store import Embeddings
from omnivat.errors import DataError
from omnivat.evaluate import label_map
from omnivat.lang.bank import LangBank
from omnivat.lang.clip_prompts import load_prompts
from omnivat.protocol.images import live_of
from omnivat.protocol.settings import Task
from omnivat.seeding import derive_seed
from omnivat.selection import Evidence, evidence_of


def source_arrays(
    found: Task, bank: LangBank | None, seed: int, pairs: Embeddings | None = None
) -> Source:
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
        prompts=None
        if texts is None or not texts.text_hash
        else partial(load_prompts, texts.encoder, texts.text_hash),
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
