"""Camera pictures: embed, predict, discard."""

from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

from app.familiar import predict_one
from app.pair_input import moved, of_ref
from app.resources import Resources
from app.state import Ref
from app.teaching import head_taught
from omnivat.errors import DataError

BOTH = "both"


def live(
    resources: Resources,
    content: bytes | Path,
    *,
    modality: str,
    other: Ref | None,
    order: float | None,
    name: str = "the image",
    taught: str = "",
    profile: str = "",
    split: int = 0,
    check: Callable[[], None] = lambda: None,
) -> dict[str, Any]:
    """Predict one picture with the other image of the pair if given, or a photo and a touch.

    content   the bytes of the picture or their file; neither is kept. With modality "both": the
              photo, then the touch
    split     "both": the bytes of the photo
    check     called regularly; an error it raises ends the work
    modality  "vis", "tac" or "both"
    order     p in quarter turns; None: the learned one
    taught    name of a taught head, from `app.teaching.taught_name`; "": the head as trained
    profile   name of a profile, from `app.sensor`; "": images as they come
    return    classes, probabilities of each reading, `images`: modality -> whether the prediction
              is a `guess`, and milliseconds of each part

    Raises DataError if the picture cannot be read or `modality` is unknown.
    """
    import torch

    from omnivat.encoders.base import for_modality

    began = perf_counter()
    head, asked = head_taught(resources, taught), {"profile": profile}
    pair: dict[str, Any] = {"vis": None, "tac": None}
    with torch.inference_mode():
        pixels = {
            one: for_modality(resources.encoder(), one).preprocess(resources.picture(part, name, check).image)
            for one, part in _parts(content, modality, split).items()
        }
        read = perf_counter()
        for one, picture in pixels.items():
            rows = for_modality(resources.encoder(), one).embed(picture[None])
            pair[one] = moved(resources, asked, one, rows)
        embedded = perf_counter()
        if other is not None and modality != BOTH:
            rest = "tac" if modality == "vis" else "vis"
            pair[rest] = of_ref(resources, other, rest, asked)
        found = predict_one(head, pair, order)
    return {
        "classes": list(head.settings.classes),
        **found,
        "ms": {"read": _ms(read - began), "encoder": _ms(embedded - read), "head": _ms(perf_counter() - embedded)},
    }


def _parts(content: bytes | Path, modality: str, split: int) -> dict[str, bytes | Path]:
    """Return modality -> content of each picture in a request."""
    if modality in ("vis", "tac"):
        return {modality: content}
    if modality != BOTH:
        raise DataError(f"modality is '{modality:.20}'; it is vis, tac or both.")
    whole = content.read_bytes() if isinstance(content, Path) else content
    if not 0 < split < len(whole):
        raise DataError(f"split is {split}; give the bytes of the photo, before those of the touch.")
    return {"vis": whole[:split], "tac": whole[split:]}


def _ms(seconds: float) -> float:
    return round(1000 * seconds, 1)
