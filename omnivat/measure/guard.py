"""The LANG guard: does a head lean on the text that it had in training?"""

import numpy as np
import torch

from omnivat.data.arrays import copied
from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.head.fusion import fused_logs
from omnivat.head.head import OmniVaT
from omnivat.head.predict_set import CHUNK, label_map, predicted_probabilities
from omnivat.head.training import training_pass
from omnivat.kit.errors import DataError
from omnivat.kit.seeding import derive_seed
from omnivat.kit.stages import IMAGES
from omnivat.measure.gaps.confusion import accuracy


@torch.no_grad()
def lang_guard(model: OmniVaT, pairs: Embeddings, bank: LangBank, *, seed: int) -> dict[str, float]:
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
    texts = torch.from_numpy(bank.embeddings[truth.numpy(), styles]).to(model.dtype)
    guided = []
    for rows in torch.arange(len(pairs)).split(CHUNK):
        images = {n: torch.from_numpy(copied(getattr(pairs, n)[rows.numpy()])) for n in IMAGES}
        on = torch.ones(len(rows), dtype=torch.bool)
        output = training_pass(model, images, texts[rows], truth[rows], lang_on=on, token_on=~on)
        guided.append(fused_logs("mean", **output.logits).argmax(-1))
    plain = predicted_probabilities(model, pairs)["fused"].argmax(-1)
    found = {
        "with": float(accuracy(truth, torch.cat(guided))),
        "without": float(accuracy(truth, plain)),
    }
    return found | {"gap": found["with"] - found["without"]}
