"""The heads of `benchmarks.twins`: what each reads of one press by every sensor."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression

from omnivat.data.embeddings import Embeddings
from omnivat.data.profile import Channels, channels_of, shrunk
from omnivat.measure.twins import Twins

Array = NDArray[Any]
READINGS = {"touch": ("tac",), "photo": ("vis",), "both": ("vis", "tac")}
PICTURES = (5, 20, 50, 200)  # without labels
# twins are tested in thirds, with pictures of the other two; draws of these pictures
PARTS, DRAWS = 3, 5
LIT = (0, 5, 20)  # pictures that give lamps, and a profile beside them; more change little
KEPT, FILLED, RELIEF = 0, 1, 2  # how a touch is read: dots as printed, filled, by relief
C = 0.003


@dataclass(frozen=True, slots=True, kw_only=True)
class Plain:
    """A logistic regression on standardised rows, and the statistics that it learned them with."""

    model: LogisticRegression
    own: Channels

    def probabilities(self, rows: Array, known: Channels | None = None) -> Array:
        """Return probabilities (n, K) of rows (n, W), standardised by the source's statistics,
        or `known` ones.
        """
        found: Array = self.model.predict_proba(standard(rows, known or self.own))
        return found

    def answers(self, rows: Array, known: Channels | None = None) -> Array:
        """Return the classes (n,) of the largest of these."""
        found: Array = self.model.classes_[self.probabilities(rows, known).argmax(1)]
        return found


def standard(rows: Array, by: Channels) -> Array:
    """Return rows (n, W) in units of some statistics."""
    return (rows - by.mean) / (np.sqrt(by.variance) + 1e-6)


def learned(rows: Array, labels: Array) -> Plain:
    """Fit the regression to unit rows (n, W)."""
    own = channels_of(rows)
    model = LogisticRegression(C=C, max_iter=1500).fit(standard(rows, own), labels)
    return Plain(model=model, own=own)


def head_of(pairs: Embeddings, source: str, reading: str) -> Plain:
    """Fit the regression to the training pairs of a domain."""
    own = pairs.in_domain(source, split="train")
    return learned(rows_of(own.vectors, reading), own.label)


def rows_of(vectors: Mapping[str, Array], reading: str) -> Array:
    """Return unit rows (..., N, W) of a reading, side by side for both."""
    parts = [vectors[name] for name in READINGS[reading]]
    count = min(part.shape[-2] for part in parts)  # of the twins, some have no photograph
    return np.concatenate([unit(part[..., :count, :]) for part in parts], axis=-1)


def unit(rows: Array) -> Array:
    """Return rows (..., W) at length 1."""
    found: Array = rows / np.linalg.norm(rows, axis=-1, keepdims=True)
    return found


def thirds(count: int, classes: int) -> list[Array]:
    """Return PARTS sets of indices; objects come in rounds of the classes, so that each part has
    as many of all.
    """
    return [np.flatnonzero(np.arange(count) // classes % PARTS == part) for part in range(PARTS)]


def pools(count: int, pictures: int, classes: int, *, seed: int) -> list[tuple[Array, Array]]:
    """Return for each third its indices, and those of `pictures` of the others, known without
    labels.
    """
    random = np.random.default_rng([seed, pictures])
    return [
        (part, random.permutation(np.setdiff1d(np.arange(count), part))[:pictures])
        for part in thirds(count, classes)
    ]


def predicted(head: Plain, rows: Array, pictures: int, classes: int, *, seed: int) -> Array:
    """Return probabilities (N, K) of rows (N, W), with `pictures` rows of the other thirds known
    without labels. Rows may be (PARTS, N, W): as they are read by what is known in each third.
    """
    rows = np.broadcast_to(rows, (PARTS, *rows.shape[-2:]))
    found = np.zeros((rows.shape[1], len(head.model.classes_)))
    for own, (part, pool) in zip(
        rows, pools(rows.shape[1], pictures, classes, seed=seed), strict=True
    ):
        known = shrunk(channels_of(own[pool]), head.own) if pictures else None
        found[part] = head.probabilities(own[part], known)
    return found


def share(right: Array) -> list[float]:
    """Return the mean of (N,) and its 95 % interval over objects."""
    mean, half = right.mean(), 1.96 * right.std(ddof=1) / len(right) ** 0.5
    return [round(float(v), 3) for v in (mean, max(mean - half, 0), min(mean + half, 1))]


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """Predictions of one head on all twins, by number of pictures (R) and target (T)."""

    right: Array  # (R, T, N) share of draws that are right
    said: Array  # (R, T, N) class of the first draw

    @property
    def count(self) -> int:
        """N, how many twins were predicted."""
        return int(self.right.shape[-1])


def seen(
    head: Plain, rows: Sequence[Array], label: Array, source: int, classes: int, look: int
) -> Seen:
    """Predict twins with no picture, and with each of `PICTURES`, of the target.

    rows  (S, N, W), or (S, PARTS, N, W), for each number of pictures, and last for the source
    """
    targets, draws = len(rows[0]), 1 if look == RELIEF else DRAWS
    shape = (1 + len(PICTURES), targets, len(label))
    right, said = np.zeros(shape), np.zeros(shape, int)
    for r, pictures in enumerate((0, *PICTURES)):
        for target in range(targets):
            known, read = (0, rows[-1]) if target == source else (pictures, rows[r])
            known = min(known, LIT[-1]) if look == RELIEF else known
            count = draws if known else 1
            for draw in range(count):
                shares = predicted(head, read[target], known, classes, seed=draw)
                answer = head.model.classes_[shares.argmax(1)]
                right[r, target] += answer == label
                if not draw:
                    said[r, target] = answer
            right[r, target] /= count
    return Seen(right=right, said=said)


def everything(
    made: Twins, learning: Sequence[Embeddings], relief: Mapping[str, Sequence[Array]]
) -> dict[tuple[str, int, int], Seen]:
    """Return (reading, source, look) -> predictions; a look is that of training and test.

    learning  the set that the heads learn from, by look
    relief    "touch", "both" -> `by_relief` of its twins by each sensor
    """
    found = {}
    classes = len(made.header.classes)
    for look, pairs in enumerate(learning):
        for reading in READINGS if not look else ("touch", "both"):
            rows = [_tested(made, reading, look, r, relief) for r in range(2 + len(PICTURES))]
            count = rows[0].shape[-2]
            for source, name in enumerate(made.header.domains):
                head = head_of(pairs, name, reading)
                found[reading, source, look] = seen(
                    head, rows, made.label[:count], source, classes, look
                )
    return found


def _tested(
    made: Twins, reading: str, look: int, r: int, relief: Mapping[str, Sequence[Array]]
) -> Array:
    """Return unit rows of twins (S, N, W), or (S, PARTS, N, W), with the pictures of number r."""
    vis = np.swapaxes(made.vis, 0, 1)
    if look == RELIEF:
        tac = np.stack([vectors[min(r, len(LIT) - 1)] for vectors in relief[reading]])
        vis = np.broadcast_to(vis[:, None], (*tac.shape[:2], *vis.shape[1:]))
    else:
        tac = np.swapaxes(made.filled if look else made.tac, 0, 1)
    return rows_of({"vis": vis, "tac": tac}, reading)
