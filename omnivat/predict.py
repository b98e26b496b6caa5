"""Predict the material of pairs, independent of the batch."""

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor

from omnivat.checkpoint import Head
from omnivat.data.profile import Profile
from omnivat.stages import optional_order

PRECISION = torch.float64  # heads in this dtype give the same digits in any batch


@torch.no_grad()
def predict_embeddings(
    head: Head, vis: Tensor | None, tac: Tensor | None, *, order: float | None = None, profile: Profile | None = None
) -> list[dict[str, Any]]:
    """Return one record for each pair, as plain values.

    vis, tac  (B, input_width) raw embeddings; one of them may be None
    order     quarter turns; None: the learned one
    profile   of the sensor that made the pairs; None: they are taken as they come
    return    B records: "prediction", "probabilities" (from all given images), "modalities" ("vis"
              and "tac", each with the other image absent) and, for a pair, "branches" (inside the
              pair), as class -> probability; "temperature" by reading; and "familiarity" by
              modality, if the head has its training embeddings
    """
    if profile is not None:
        vis, tac = (
            None if rows is None else head.moved(name, rows, profile) for name, rows in (("vis", vis), ("tac", tac))
        )
    device = head.model.classifier.device
    given = [None if rows is None else rows.to(device) for rows in (vis, tac)]
    readings = head.model(*given, order=optional_order(order)).readings
    found = {name: values.cpu() for name, values in readings.items()}
    fused = found["fused"]
    alone = {name: found[name] for name in ("vis", "tac") if name in found}
    branches = {name: found[f"{name}_branch"] for name in alone if f"{name}_branch" in found}
    looked = head.familiarity.look(vis, tac) if head.familiarity else None
    return [
        {
            "prediction": head.settings.classes[int(fused[row].argmax())],
            "probabilities": _named(head.settings.classes, fused[row]),
            "modalities": {name: _named(head.settings.classes, values[row]) for name, values in alone.items()},
            **_branches(head.settings.classes, branches, row),
            "temperature": dict(head.model.calibration.temperature),
            "familiarity": looked[row] if looked else {},
            "order": head.model.order if order is None else order,
            "profile": profile.counts if profile else {},
        }
        for row in range(len(fused))
    ]


def _named(classes: Sequence[str], values: Tensor) -> dict[str, float]:
    return dict(zip(classes, values.tolist(), strict=True))


def _branches(classes: Sequence[str], branches: dict[str, Tensor], row: int) -> dict[str, dict[str, dict[str, float]]]:
    if not branches:
        return {}
    return {"branches": {name: _named(classes, values[row]) for name, values in branches.items()}}
