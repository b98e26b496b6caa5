"""Small sets and heads that many tests build: vectors as a set, and settings of a head for one."""

import numpy as np
import torch

from omnivat.data.embeddings import Embeddings, Header
from omnivat.data.store import ROW_NAMES
from omnivat.head.settings import HeadSettings

CLASSES = ("wood", "steel", "plastic", "ceramic", "glass")


def embeddings_of(vis, tac, domain, label, *, domains, classes=CLASSES, rows=None, **flips):
    """Return vectors as a set; columns of text that are not in `rows` are empty."""
    header = Header(
        encoder="test-encoder",
        weights_hash="0" * 16,
        preprocessing="none",
        domains=domains,
        classes=classes,
        simulated=True,
        origin="made by a test",
    )
    empty = {name: [""] * len(label) for name in ROW_NAMES}
    return Embeddings(
        header=header,
        vis=vis.astype(np.float32),
        tac=tac.astype(np.float32),
        domain=domain,
        label=label,
        rows=empty | (rows or {}),
        **flips,
    )


def move_domains(embeddings, length, *, seed=0):
    """Add an offset of its own to each domain but the first, in place: a profile finds it."""
    random = np.random.default_rng(seed)
    for rows in (embeddings.vis, embeddings.tac):
        offset = length * random.normal(size=(len(embeddings.header.domains), embeddings.width))
        offset[0] = 0
        rows += offset[embeddings.domain].astype(np.float32)
    return embeddings


def head_settings(embeddings=None, **changes):
    """Return settings of a light head for a set; None: for those of `make_embeddings`."""
    values = {"classes": CLASSES, "input_width": 24, "width": 32}
    if embeddings is not None:
        values |= {"classes": embeddings.header.classes, "input_width": embeddings.width}
    return HeadSettings(**(values | changes))


def equal_weights(first, second):
    one, two = first.state_dict(), second.state_dict()
    return all(torch.equal(one[name], two[name]) for name in one)
