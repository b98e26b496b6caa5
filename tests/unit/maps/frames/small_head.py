"""A small head, pairs for it, and the orders and maps of their frames."""

import numpy as np

from omnivat.data.store import Embeddings, Header
from omnivat.head.head import build_head
from omnivat.head.settings import HeadSettings

CLASSES = ("wood", "steel", "glass")


ORDERS = (0.0, 0.25, 0.5, 0.75, 1.0)


MAPS = {"pca/raw": 5, "pca/frft": 5, "pca/relu": 5, "pca/f_hat": 5, "umap/f_hat": 3}


def pairs(count=24, width=12, classes=CLASSES, domains=2):
    rng = np.random.default_rng(0)
    return Embeddings(
        header=Header(
            encoder="noise",
            weights_hash="none",
            preprocessing="none",
            domains=tuple(f"D{d}" for d in range(domains)),
            classes=classes,
            simulated=True,
            origin="random numbers",
        ),
        vis=rng.normal(size=(count, width)).astype(np.float32),
        tac=rng.normal(0.5, size=(count, width)).astype(np.float32),
        domain=np.arange(count) % domains,
        label=rng.integers(0, len(classes), count),
        rows={name: [""] * count for name in ("vis", "tac", "object", "split", "part")},
    )


def head(width=12):
    settings = HeadSettings(
        classes=CLASSES, input_width=12, width=width, lang_width=12, standardize=False
    )
    return build_head(settings, seed=1).eval()
