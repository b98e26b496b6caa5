"""Ridge regressions of labels, with every object left out in closed form, and their blend.

Source: leaving out as in Rifkin and Lippert, "Notes on regularized least squares"
(MIT-CSAIL-TR-2007-025), for whole objects.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

PENALTY = 1.0  # of squared weights; a row has length 1, and a constant 1 beside it
WEIGHT = 10  # of a class's lessons together, in training pairs
SHARPNESS = (0.5, 50.0)  # least and most, of scores
Rows = NDArray[np.float64]
Labels = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Ridge:
    """A ridge regression of one-hot classes, and its predictions for rows that it did not see."""

    weights: Rows  # (2 W, K)
    bias: Rows  # (K,)
    apart: Rows  # (L, K) scores of each lesson by the regression without its object


def ridge(
    rows: Rows, labels: Labels, counts: Rows, classes: int, groups: Sequence[Labels]
) -> Ridge:
    """Solve the regression of one-hot labels (N,) on rows (N, 2 W) of which each counts `counts`
    (N,) times.

    groups  the places of each object's lessons, which are left out together; lessons are the first
            rows

    """
    targets = np.eye(classes)[labels]
    shares, errors = solved(rows @ rows.T + 1 + PENALTY * np.diag(1 / counts), targets, groups)
    return Ridge(rows.T @ shares, shares.sum(0), targets[: len(errors)] - errors)


def solved(matrix: Rows, targets: Rows, groups: Sequence[Labels]) -> tuple[Rows, Rows]:
    """Return a = matrix⁻¹ targets (N, K), and the errors (L, K) of each group's rows without it:
    (matrix⁻¹ of the group)⁻¹ (a of the group). The L rows of all groups are the first ones.
    """
    inverse = np.linalg.inv(matrix)
    shares = inverse @ targets
    errors = np.empty((sum(map(len, groups)), targets.shape[1]))
    for group in groups:
        errors[group] = np.linalg.solve(inverse[np.ix_(group, group)], shares[group])
    return shares, errors


def weight_of(labels: Labels) -> float:
    """Return how many training pairs each lesson counts as."""
    return max(1.0, WEIGHT * len(np.unique(labels)) / len(labels))


def share_of_lessons(both: Rows, lessons: Rows) -> float:
    """Return t, 0 to 1, with the least squared error of (1 - t) both + t lessons: errors (L, K)
    of each map.
    """
    apart = both - lessons
    return float(np.clip((both * apart).sum() / max((apart**2).sum(), 1e-12), 0, 1))


def sharpness(scores: Rows, labels: Labels) -> float:
    """Return the factor of scores (L, K) whose softmax has the least log loss, within SHARPNESS.

    One more lesson, of every class alike, keeps it finite.
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
