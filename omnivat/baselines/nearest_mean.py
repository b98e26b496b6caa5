"""Nearest class mean: the class whose mean direction in the source is closest."""

import torch
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.baselines.contract import Fitted, Predict, Source, fused
from omnivat.baselines.evidence import best

CANDIDATES = {
    f"{'centred' if centred else 'plain'}, sharpness {sharpness:g}": (centred, sharpness)
    for centred in (False, True)
    for sharpness in (5.0, 10.0, 20.0, 50.0, 100.0)
}


def fit(source: Source) -> Fitted:
    """Store a mean direction for each class and modality; held-out objects choose the settings."""
    chosen = best(source, CANDIDATES, lambda part, choice: lambda v, t: _model(part, *choice)(v, t)["fused"])
    return Fitted(
        predict=_model(source, *CANDIDATES[chosen]),
        chosen={"means": chosen},
        parameters=2 * len(source.classes) * source.width,
    )


def _model(source: Source, centred: bool, sharpness: float) -> Predict:
    full = source.both_views()
    names = {"vis": full.vis, "tac": full.tac}
    middle, means = {}, {}
    for name, rows in names.items():
        unit = normalize(rows, dim=-1)
        middle[name] = unit.mean(0) if centred else torch.zeros_like(unit[0])
        means[name] = class_directions(unit - middle[name], full.labels, len(source.classes))

    def predict(vis: Tensor, tac: Tensor) -> dict[str, Tensor]:
        return fused(
            {
                name: _nearest(normalize(rows, dim=-1) - middle[name], means[name], sharpness)
                for name, rows in (("vis", vis), ("tac", tac))
            }
        )

    return predict


def class_directions(rows: Tensor, labels: Tensor, classes: int) -> Tensor:
    """Return the mean direction (K, D) of each class's rows (N, D); zero for an absent class."""
    sums = rows.new_zeros(classes, rows.shape[1]).index_add_(0, labels, normalize(rows, dim=-1))
    return normalize(sums, dim=-1)


def _nearest(rows: Tensor, means: Tensor, sharpness: float) -> Tensor:
    return (sharpness * normalize(rows, dim=-1) @ means.T).softmax(-1)
