"""Source-side evidence for choosing settings: held-out objects of the source, plain and shifted.

Targets are never used. Held-out objects alone measure how well a method fits its source, but a new
sensor also shifts all embeddings of a modality. An imitated sensor applies one random offset and
one random scale to all held-out pairs of a modality, drawn at the scale of the source's spread.
Several draws imitate several unknown sensors, of two kinds:

axes    each axis is shifted independently, including axes that hardly vary
spread  the offset is drawn from the distribution of the source's pairs, along the directions in
        which they differ: same norm, more damaging, because classes differ along them
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.splits import hold_out
from omnivat.data.store import Embeddings
from omnivat.kit.errors import DataError
from omnivat.kit.seeding import derive_seed

FRACTION = 0.25
SHIFTS = 6  # of each kind
KINDS = ("axes", "spread")


def evidence(source: Embeddings) -> tuple[Embeddings, list[Embeddings]]:
    """Split a source's training pairs by object: those to train on, and the held-out ones, plain
    and under imitated sensors of each kind.

    Raises DataError if no object can be held out.
    """
    seed = derive_seed(0, "evidence", 0)
    held = hold_out(source.rows["object"], source.label, FRACTION, seed=seed)
    if not held.any():
        raise DataError("No object of the source can be held out: every class has one object only.")
    fit, rest = source.select(~held), source.select(held)
    shifted = [
        shift(rest, fit, derive_seed(seed, kind, number), kind=kind)
        for kind in KINDS
        for number in range(SHIFTS)
    ]
    return fit, [rest, *shifted]


def shift(pairs: Embeddings, reference: Embeddings, seed: int, *, kind: str) -> Embeddings:
    """Return the pairs as measured by imitated sensors.

    "axes"    x -> mean + (x - mean) (1 + a) + std b, a in [-0.5, 0.5] and b ~ N(0, 1) by axis
    "spread"  x -> mean + (x - mean) (1 + a) + z, one a, and z ~ N(0, covariance of reference)

    The draw is the same for all pairs of a modality.
    """
    random = np.random.default_rng(seed)
    vis, tac = (
        imitated(getattr(pairs, name), getattr(reference, name), random, kind)
        for name in ("vis", "tac")
    )
    return replace(pairs, vis=vis, tac=tac, vis_flip=None, tac_flip=None)


def imitated(
    rows: NDArray[Any], reference: NDArray[Any], random: np.random.Generator, kind: str
) -> NDArray[np.float32]:
    """Return rows (N, W) of one modality as an imitated sensor measures them; see `shift`."""
    mean = reference.mean(0)
    stretch = 1 + random.uniform(-0.5, 0.5, len(mean) if kind == "axes" else None)
    if kind == "axes":
        offset = reference.std(0) * random.normal(size=len(mean))
    else:  # covariance: that of the reference
        weights = random.normal(size=len(reference)) / len(reference) ** 0.5
        offset = weights @ (reference - mean)
    moved: NDArray[np.float32] = (mean + (rows - mean) * stretch + offset).astype(np.float32)
    return moved
