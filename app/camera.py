"""Camera pictures: embed, predict, discard."""

from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

from app.familiar import looked_at
from app.resources import Resources
from app.state import Ref
from app.teaching import head_taught
from omnivat.errors import DataError


def live(
    resources: Resources,
    content: bytes | Path,
    *,
    modality: str,
    other: Ref | None,
    order: float | None,
    name: str = "the image",
    taught: str = "",
    check: Callable[[], None] = lambda: None,
) -> dict[str, Any]:
    """Predict one picture, together with the other image of the pair if given.

    content   the bytes of the picture or their file; neither is kept
    check     called regularly; an error it raises ends the work
    modality  "vis" or "tac"
    order     p in quarter turns; None: the learned one
    taught    name of a taught head, from `app.teaching.taught_name`; "": the head as trained
    return    classes, probabilities of each reading, `images`: modality -> whether the prediction
              is a `guess`, and milliseconds of each part

    Raises DataError if the picture cannot be read or `modality` is unknown.
    """
    if modality not in ("vis", "tac"):
        raise DataError(f"modality is '{modality:.20}'; it is vis or tac.")
    import torch

    from omnivat.encoders.paired import for_modality

    began = perf_counter()
    encoder = for_modality(resources.encoder(), modality)
    head = head_taught(resources, taught)
    with torch.inference_mode():
        pixels = encoder.preprocess(resources.picture(content, name, check).image)
        read = perf_counter()
        pair: dict[str, Any] = {"vis": None, "tac": None, modality: encoder.embed(pixels[None])}
        embedded = perf_counter()
        if other is not None:
            rest = "tac" if modality == "vis" else "vis"
            pair[rest] = torch.from_numpy(resources.embedding(other, rest).copy())[None]
        out = head.model(pair["vis"], pair["tac"], order=order)
        looked = looked_at(head, pair["vis"], pair["tac"])
    return {
        "classes": list(head.settings.classes),
        "readings": {
            name: [round(float(p), 5) for p in values[0]] for name, values in out.readings.items()
        },
        "images": looked,
        "ms": {
            "read": _ms(read - began),
            "encoder": _ms(embedded - read),
            "head": _ms(perf_counter() - embedded),
        },
    }


def _ms(seconds: float) -> float:
    return round(1000 * seconds, 1)
