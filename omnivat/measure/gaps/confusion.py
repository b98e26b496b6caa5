"""Scores of a classifier: confusion, accuracy, balanced accuracy and macro-F1."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from jaxtyping import Float, Int, Int64
from torch import Tensor

from omnivat.kit.shapes import require_shapes

UNEVEN = 1.5  # times the mean size of a class: from such a largest class on, accuracy misleads


def confusion(
    labels: Int[Tensor, " N"], predicted: Int[Tensor, " N"], classes: int
) -> Int64[Tensor, "K K"]:
    """Count how often each class (row) is predicted as each class (column)."""
    require_shapes(labels=(labels, "N"), predicted=(predicted, "N"))
    return torch.bincount(labels * classes + predicted, minlength=classes**2).view(classes, classes)


def accuracy(labels: Int[Tensor, " N"], predicted: Int[Tensor, " N"]) -> Float[Tensor, ""]:
    """Return the share of correct predictions; NaN for no pairs."""
    require_shapes(labels=(labels, "N"), predicted=(predicted, "N"))
    return (labels == predicted).to(torch.get_default_dtype()).mean()


@dataclass(frozen=True, slots=True)
class Balance:
    """What accuracy hides where one class is larger than others.

    always    share of the largest class: the accuracy of always naming it
    balanced  mean over classes of the share of their pairs that are right (balanced accuracy)
    uneven    True if the largest class has at least 1.5 times the mean size of a class
    """

    always: float
    balanced: float
    uneven: bool


def balance(counts: Any) -> Balance:
    """Return the balance of a confusion matrix (K, K) with at least one pair; classes without a
    pair do not count.

    >>> balance([[45, 0], [5, 0]])  # always the first class: 45 of 50 right
    Balance(always=0.9, balanced=0.5, uneven=True)
    """
    table = np.asarray(counts, np.float64)
    sizes = table.sum(1)
    kept = sizes > 0
    recall = table.diagonal()[kept] / sizes[kept]
    largest = float(sizes.max() / sizes.sum())
    return Balance(largest, float(recall.mean()), largest * int(kept.sum()) >= UNEVEN)


def macro_f1(
    labels: Int[Tensor, " N"], predicted: Int[Tensor, " N"], *, union: bool = False
) -> Float[Tensor, ""]:
    """Return the mean over classes of F1 = 2 TP / (2 TP + FP + FN).

    union   False: over classes among the labels. True: over classes among labels or predictions, so
            predicting a class that the set lacks adds a zero (scikit-learn's default)
    return  in [0, 1]; NaN for no pairs

    Raises ShapeError for other shapes.

    >>> import torch
    >>> labels, predicted = torch.tensor([0, 0, 0, 1]), torch.tensor([0, 0, 0, 2])
    >>> accuracy(labels, predicted)
    tensor(0.7500)
    >>> macro_f1(labels, predicted), macro_f1(labels, predicted, union=True)
    (tensor(0.5000), tensor(0.3333))
    """
    require_shapes(labels=(labels, "N"), predicted=(predicted, "N"))
    if not len(labels):
        return torch.tensor(float("nan"))
    counts = confusion(labels, predicted, int(torch.maximum(labels.max(), predicted.max())) + 1)
    right, truth, predictions = counts.diagonal(), counts.sum(1), counts.sum(0)
    kept = truth + predictions > 0 if union else truth > 0
    scores = 2 * right[kept] / (truth + predictions)[kept]
    return scores.mean()


def scores(truth: Tensor, predicted: Tensor) -> dict[str, float]:
    """Return ACC and macro-F1 of predicted classes (N,), and F1 over the union with the
    predicted ones.
    """
    return {
        "accuracy": float(accuracy(truth, predicted)),
        "macro_f1": float(macro_f1(truth, predicted)),
        "macro_f1_union": float(macro_f1(truth, predicted, union=True)),
    }
