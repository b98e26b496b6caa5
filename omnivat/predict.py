"""Predict the material of pairs, the same alone or in any batch."""

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor

from omnivat.checkpoint import Head
from omnivat.errors import SettingsError

PRECISION = torch.float64  # load heads so, and a batch changes no digit that anyone reads


def checked_order(order: float | None) -> float | None:
    """Return the order, or refuse one that is not a finite number of quarter turns."""
    if order is not None and not abs(order) <= 1e6:
        raise SettingsError(f"order is {order}; give a finite number of quarter turns up to 1e6.")
    return order


@torch.no_grad()
def predict_embeddings(
    head: Head, vis: Tensor | None, tac: Tensor | None, *, order: float | None = None
) -> list[dict[str, Any]]:
    """Return one answer a pair, as plain values.

    vis, tac  (B, input_width) raw embeddings; one of them may be None
    order     quarter turns; the learned one where None
    return    B records: "prediction", "probabilities" (fused) and "modalities", each a class ->
              probability map that sums to one
    """
    output = head.model(vis, tac, order=checked_order(order))
    fused, alone = output.probabilities, output.modality_probabilities
    return [
        {
            "prediction": head.settings.classes[int(fused[row].argmax())],
            "probabilities": _named(head.settings.classes, fused[row]),
            "modalities": {
                name: _named(head.settings.classes, values[row]) for name, values in alone.items()
            },
            "order": head.model.order if order is None else order,
        }
        for row in range(len(fused))
    ]


def _named(classes: Sequence[str], values: Tensor) -> dict[str, float]:
    return dict(zip(classes, values.tolist(), strict=True))
