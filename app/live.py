"""One picture of a camera after the other: embed, answer, forget."""

from time import perf_counter
from typing import Any

from app.resources import Resources
from app.state import Ref
from omnivat.errors import DataError


def live(
    resources: Resources,
    content: bytes,
    *,
    modality: str,
    other: Ref | None,
    order: float | None,
    name: str = "",
) -> dict[str, Any]:
    """Answer one picture, with the other image of the pair where there is one.

    content   the bytes of the picture, which is not kept
    modality  what it is, "vis" or "tac"
    order     p in quarter turns; the learned one if None
    return    classes, probabilities by modality and of both, and milliseconds of each part

    Raises DataError when the picture cannot be read or `modality` is unknown.
    """
    if modality not in ("vis", "tac"):
        raise DataError(f"modality is '{modality:.20}'; it is vis or tac.")
    import torch

    from omnivat.data.images import read_image

    began = perf_counter()
    encoder, head = resources.encoder(), resources.head()
    with torch.inference_mode():
        pixels = encoder.preprocess(read_image(content, name=name))
        read = perf_counter()
        pair: dict[str, Any] = {"vis": None, "tac": None, modality: encoder.embed(pixels[None])}
        embedded = perf_counter()
        if other is not None:
            rest = "tac" if modality == "vis" else "vis"
            pair[rest] = torch.from_numpy(resources.embedding(other, rest).copy())[None]
        out = head.model(pair["vis"], pair["tac"], order=order)
    found = {**out.modality_probabilities, "both": out.probabilities}
    return {
        "classes": list(head.settings.classes),
        "probabilities": {
            name: [round(float(p), 5) for p in values[0]] for name, values in found.items()
        },
        "ms": {
            "read": _ms(read - began),
            "encoder": _ms(embedded - read),
            "head": _ms(perf_counter() - embedded),
        },
    }


def _ms(seconds: float) -> float:
    return round(1000 * seconds, 1)
