"""A small head, pairs for it, and the orders and maps of their frames."""

import numpy as np

from omnivat.head.head import build_head
from tests.builders import embeddings_of, head_settings

CLASSES = ("wood", "steel", "glass")


ORDERS = (0.0, 0.25, 0.5, 0.75, 1.0)


MAPS = {"pca/raw": 5, "pca/frft": 5, "pca/relu": 5, "pca/f_hat": 5, "umap/f_hat": 3}


def pairs(count=24, width=12, classes=CLASSES, domains=2):
    random = np.random.default_rng(0)
    return embeddings_of(
        random.normal(size=(count, width)),
        random.normal(0.5, size=(count, width)),
        np.arange(count) % domains,
        random.integers(0, len(classes), count),
        domains=tuple(f"D{d}" for d in range(domains)),
        classes=classes,
    )


def head(width=12):
    size = {"input_width": 12, "width": width, "lang_width": 12}
    return build_head(head_settings(classes=CLASSES, standardize=False, **size), seed=1).eval()
