"""Predict the material of pairs, independent of the batch."""

from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from omnivat.data.dots import dots_of
from omnivat.data.profile import Profile
from omnivat.data.relief.files import touch_of
from omnivat.encoders import load_encoder
from omnivat.encoders.cache import embed_pair
from omnivat.head.checkpoint import Head
from omnivat.kit.files import path_of
from omnivat.kit.shapes import floating
from omnivat.kit.stages import IMAGES, optional_order


def predict_pair(
    head: Head,
    vis: str | Path | None,
    tac: str | Path | None,
    *,
    order: float | None = None,
    profile: Profile | None = None,
) -> dict[str, Any]:
    """Return the record of `predict_embeddings` for a photo and a tactile image, two files.

    vis, tac  one of them may be None

    The head's own encoder reads them; it is loaded in every call, so for many pairs embed them
    first. Raises DataError for a file that is no picture, and for an encoder that is not here.

    >>> from omnivat import EXAMPLES, load_head
    >>> touched = EXAMPLES / "pairs" / "TQ-DIGIT-sim" / "glass"
    >>> files = touched / "glass-27_vis.jpg", touched / "glass-27_tac.jpg"
    >>> predict_pair(load_head(EXAMPLES / "own"), *files)["prediction"]
    'glass'
    """
    made, lamps = head.encoder, profile.lamps if profile else None
    encoder = load_encoder(
        made["name"],
        weights_hash=made["weights_hash"],
        dots=dots_of(made["preprocessing"]),
        touch=touch_of(made["preprocessing"]),
        lamps={"": lamps} if lamps else {},
    )
    key = (encoder.name, encoder.weights_hash, encoder.preprocessing)
    head.require(key, encoder.width, what="Embeddings of these images")
    photo, touch = (None if file is None else path_of(file) for file in (vis, tac))
    embedded = embed_pair(encoder, photo, touch)
    rows = [
        None if vector is None else torch.from_numpy(vector[None].copy()) for vector in embedded
    ]
    return predict_embeddings(head, *rows, order=order, profile=profile)[0]


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
