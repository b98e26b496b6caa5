"""Scores of a classifier: confusion, accuracy and macro-F1."""

import torch
from jaxtyping import Float, Int, Int64
from torch import Tensor

from omnivat.kit.shapes import require_shapes


def confusion(
    labels: Int[Tensor, " N"], predicted: Int[Tensor, " N"], classes: int
) -> Int64[Tensor, "K K"]:
    """Count how often each class (row) is predicted as each class (column)."""
    require_shapes(labels=(labels, "N"), predicted=(predicted, "N"))
    return torch.bincount(labels * classes + predicted, minlength=classes**2).view(classes, classes)


def accuracy(labels: Int[Tensor, " N"], predicted: Int[Tensor, " N"]) -> Float[Tensor, ""]:
    """Share of correct predictions; NaN for no pairs."""
    require_shapes(labels=(labels, "N"), predicted=(predicted, "N"))
    return (labels == predicted).to(torch.get_default_dtype()).mean()


def macro_f1(
    labels: Int[Tensor, " N"], predicted: Int[Tensor, " N"], *, union: bool = False
) -> Float[Tensor, ""]:
    """Mean over classes of F1 = 2 TP / (2 TP + FP + FN).

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
