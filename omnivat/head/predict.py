"""Predict the material of pairs, independent of the batch."""

from typing import Any

import torch
from torch import Tensor

from omnivat.data.profile import Profile
from omnivat.head.checkpoint import Head
from omnivat.kit.shapes import floating
from omnivat.kit.stages import IMAGES, optional_order


@torch.no_grad()
def predict_embeddings(
    head: Head,
    vis: Tensor | None,
    tac: Tensor | None,
    *,
    order: float | None = None,
    profile: Profile | None = None,
) -> list[dict[str, Any]]:
    """Return one record for each pair, as plain values.

    vis, tac  (B, input_width) raw embeddings; one of them may be None
    order     quarter turns; None: the learned one
    profile   of the sensor that made the pairs; None: they are taken as they come
    return    B records: "prediction", "probabilities" (from all given images), "modalities" ("vis"
              and "tac", each with the other image absent) and, for a pair, "branches" (inside the
              pair), as class -> probability; "temperature" by reading; and "familiarity" by
              modality, if the head has its training embeddings

    >>> from omnivat import default_embeddings, default_head, load_embeddings, load_head
    >>> head, pairs = load_head(default_head()), load_embeddings(default_embeddings())
    >>> vis, tac = (torch.tensor(rows[:2]) for rows in (pairs.vis, pairs.tac))
    >>> first, second = predict_embeddings(head, vis, tac)
    >>> first["prediction"] in head.settings.classes, round(sum(first["probabilities"].values()), 3)
    (True, 1.0)
    >>> list(predict_embeddings(head, None, tac)[0]["modalities"])  # touch alone
    ['tac']
    """
    given = (("vis", vis), ("tac", tac))
    images = {name: floating(name, rows) for name, rows in given if rows is not None}
    as_they_come = [images.get(name) for name in IMAGES]
    if profile is not None:
        images = {name: head.moved(name, rows, profile) for name, rows in images.items()}
    vis, tac = (images[n].to(head.model.classifier.device) if n in images else None for n in IMAGES)
    readings = head.model(vis, tac, order=optional_order(order)).readings
    looked = head.familiarity.look(*as_they_come) if head.familiarity else None
    shares = {name: values.tolist() for name, values in readings.items()}
    classes, fused = head.settings.classes, readings["fused"].argmax(1).tolist()

    def named(row: int, reading: str) -> dict[str, float]:
        return dict(zip(classes, shares[reading][row], strict=True))

    def by_image(row: int, ending: str = "") -> dict[str, dict[str, float]]:
        return {name: named(row, name + ending) for name in IMAGES if name + ending in shares}

    return [
        {
            "prediction": classes[best],
            "probabilities": named(row, "fused"),
            "modalities": by_image(row),
            **({"branches": branches} if (branches := by_image(row, "_branch")) else {}),
            "temperature": dict(head.model.temperatures),
            "familiarity": looked[row] if looked else {},
            "order": head.model.order if order is None else order,
            "profile": profile.counts if profile else {},
        }
        for row, best in enumerate(fused)
    ]
