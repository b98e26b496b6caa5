"""A ridge regression of what a head's probabilities leave over of the labels.

Scores of a row x are t P(x) + Wᵀx + b: P is the head's own prediction, and W and b are a ridge
regression of the labels minus t P. The share t has the least squared error over the lessons, each
predicted without its object, where the head counts as right on one object more. All of it follows
from one linear system in closed form; a lesson more or less moves it little.

Source: leaving out as in Rifkin and Lippert, "Notes on regularized least squares"
(MIT-CSAIL-TR-2007-025), for whole objects; the share as in Breiman, "Stacked regressions" (Machine
Learning 24, 1996).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

PENALTY = 0.3  # of squared weights; a row has length 1, and a constant 1 beside it
SHARPNESS = (0.5, 50.0)  # least and most, of scores
Rows = NDArray[np.float64]
Labels = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ridge:
    """The regressions of L lessons: first of their labels, then of the head's prediction."""

    targets: Rows  # (L, K) one-hot labels
    solved: Rows  # (2, L, K) weight of each lesson
    errors: Rows  # (2, L, K) at each lesson, without its object

    def share(self, groups: Sequence[Labels]) -> float:
        """Return t, 0 to 1, as the lessons of `groups` choose it."""
        labels, head = self.errors[:, np.concatenate(groups)]
        size, one = (head**2).sum(), (head**2).sum() / len(groups)
        return float(np.clip(((labels * head).sum() + one) / (size + one), 0, 1))

    def weights(self, share: float) -> Rows:
        """Return (L, K): W is the sum of the rows so weighted, b that of the weights."""
        weights: Rows = self.solved[0] - share * self.solved[1]
        return weights

    def apart(self, share: float) -> Rows:
        """Return the scores (L, K) of each lesson without its object."""
        scores: Rows = self.targets - self.errors[0] + share * self.errors[1]
        return scores


def ridge(rows: Rows, targets: Rows, before: Rows, groups: Sequence[Labels]) -> Ridge:
    """Solve the regressions.

    rows    (L, 2 W);  targets  (L, K) one-hot labels;  before  (L, K) the head's prediction
    groups  the places of each object's lessons, which are left out together
    """
    system = rows @ rows.T + 1 + PENALTY * np.eye(len(rows))
    inverse = np.asarray(np.linalg.inv(system), np.float64)
    solved: Rows = inverse @ np.stack((targets, before))
    errors = np.empty_like(solved)
    for group in groups:
        errors[:, group] = np.linalg.solve(inverse[np.ix_(group, group)], solved[:, group])
    return Ridge(targets=targets, solved=solved, errors=errors)


def sharpness(scores: Rows, labels: Labels) -> float:
    """Return the factor of scores (L, K) whose softmax has the least log loss, within SHARPNESS.

    One more lesson, of every class alike, keeps it finite.

    >>> right, unsure = np.eye(3) * 2, np.eye(3) / 4
    >>> sharpness(right, np.arange(3)) < sharpness(unsure, np.arange(3))
    True
    """
    own, count = scores[np.arange(len(labels)), labels], len(labels)
    low, high = SHARPNESS
    for _ in range(40):  # the slope of the loss rises with the factor
        factor = (low + high) / 2
        shares = np.exp(factor * (scores - scores.max(1, keepdims=True)))
        mean = (shares / shares.sum(1, keepdims=True) * scores).sum(1)
        slope = (mean - own).sum() + (mean - scores.mean(1)).sum() / count
        low, high = (factor, high) if slope < 0 else (low, factor)
    return high
