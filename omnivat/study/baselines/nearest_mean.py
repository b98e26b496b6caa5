"""Nearest class mean: the class whose mean direction in the source is closest."""

from dataclasses import replace

import torch
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.study.baselines.contract import Fitted, Source, late
from omnivat.study.baselines.evidence import best

CANDIDATES = {
    f"{'centred' if centred else 'plain'}, sharpness {sharpness:g}": (centred, sharpness)
    for centred in (False, True)
    for sharpness in (5.0, 10.0, 20.0, 50.0, 100.0)
}


def fit(source: Source) -> Fitted:
    """Store a mean direction for each class and modality; held-out objects choose the settings."""
    chosen = best(source, CANDIDATES, _fitted)
    return replace(_fitted(source, CANDIDATES[chosen]), chosen={"means": chosen})


def _fitted(source: Source, choice: tuple[bool, float]) -> Fitted:
    (centred, sharpness), full = choice, source.both_views()
    unit = {name: normalize(rows, dim=-1) for name, rows in full.images.items()}
    middle = {
        name: rows.mean(0) if centred else torch.zeros_like(rows[0]) for name, rows in unit.items()
    }
    means = {
        n: class_directions(rows - middle[n], full.labels, len(full.classes))
        for n, rows in unit.items()
    }

    def alone(name: str, rows: Tensor) -> Tensor:
        rows = normalize(normalize(rows, dim=-1) - middle[name], dim=-1)
        return (sharpness * rows @ means[name].T).softmax(-1)

    return Fitted(predict=late(alone), parameters=2 * len(source.classes) * source.width)


def class_directions(rows: Tensor, labels: Tensor, classes: int) -> Tensor:
    """Return the mean direction (K, D) of each class's rows (N, D); zero for an absent class."""
    sums = rows.new_zeros(classes, rows.shape[1]).index_add_(0, labels, normalize(rows, dim=-1))
    return normalize(sums, dim=-1)
