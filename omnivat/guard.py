"""The LANG guard: how much a head depends on text, which prediction does not have.

In training, F-bar of LANG guides half of the pairs. It is the text of their class, so a head can
read the label from it. The guard predicts the source's test pairs with that text and without. The
gap should be below five points; a larger one means that part of the training learned to read
labels.
"""

import numpy as np
import torch
from torch import Tensor

from omnivat.data.store import Embeddings
from omnivat.errors import DataError
from omnivat.evaluate import CHUNK, label_map, predicted_probabilities
from omnivat.gaps.confusion import accuracy
from omnivat.lang.bank import LangBank
from omnivat.model.fusion import fuse
from omnivat.model.head import OmniVaT
from omnivat.seeding import derive_seed


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
    for start in range(0, len(pairs), CHUNK):
        rows = slice(start, start + CHUNK)
        own = labels[rows]
        output = model.training_pass(
            torch.from_numpy(np.array(pairs.vis[rows])),
            torch.from_numpy(np.array(pairs.tac[rows])),
            texts[rows].to(model.dtype),
            own,
            lang_on=torch.ones_like(own, dtype=torch.bool),
            token_on=torch.zeros_like(own, dtype=torch.bool),
        )
        found.append(fuse("mean", output.logits, None, model.calibration))
    return torch.cat(found)
