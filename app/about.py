"""What is loaded: its origin and limits, and whether head and set fit."""

import json
import shlex
from collections.abc import Callable
from math import isfinite
from pathlib import Path
from typing import Any

from app.components import WEB
from app.limits import MAX_IMAGE_BYTES, MAX_PIXELS
from app.messages import without_places
from app.resources import Resources
from app.sensor import from_the_start
from omnivat.kit.errors import DataError
from omnivat.kit.schema import read_object

FITS = dict.fromkeys(("problem", "remedy", "command"), "")
REMEDY = (
    "This command trains a small head on the set, tests it on objects that it has not seen, and"
    " opens the page with it."
)
UNABLE = (
    "No domain has pairs of two classes, so no head can learn from the set. This command measures"
    " gaps, retrieval and neighbours, which need none."
)


def glossary(_: Resources) -> dict[str, str]:
    """Return each term of the field with its sentence; docs/glossary.md is made from the same
    file.
    """
    terms: dict[str, str] = json.loads(
        (WEB / "shared" / "glossary.json").read_text(encoding="utf-8")
    )
    return terms


def about(resources: Resources) -> dict[str, Any]:
    """Return facts about the loaded parts; a missing part gives a sentence."""
    return {
        "head": _or_problem(head_facts, resources),
        "embeddings": _or_problem(embedding_facts, resources),
        "sensor": _or_problem(from_the_start, resources),
        "examples": len(resources.examples()),
        "limits": {"image_bytes": MAX_IMAGE_BYTES, "image_pixels": MAX_PIXELS},
    }


def head_facts(resources: Resources) -> dict[str, Any]:
    """Return facts from the head's folder."""
    head = resources.head()
    settings = head.settings
    return {
        "name": _place(resources.where.head),
        "classes": list(settings.classes),
        **{
            name: getattr(settings, name)
            for name in ("width", "input_width", "expansion", "levels")
        },
        "order": head.model.order,
        "parameters": sum(p.numel() for p in head.model.parameters()),
        "encoder": head.encoder,
        "provenance": without_nan(head.provenance),
        "metrics": without_nan(head.metrics),
    }


def own(resources: Resources) -> dict[str, Any]:
    """Return what the head for one's own pictures reads right in sensors that it has not seen; {}
    without such a head. The head is not loaded.
    """
    folder = resources.where.own
    found: dict[str, Any] = without_nan(read_object(folder / "metrics.json")) if folder else {}
    return found


def embedding_facts(resources: Resources) -> dict[str, Any]:
    """Return facts from the set's header, and the number of pairs in each domain and class."""
    import numpy as np

    embeddings = resources.embeddings()
    header = embeddings.header
    counts = np.zeros((len(header.domains), len(header.classes)), dtype=int)
    np.add.at(counts, (embeddings.domain, embeddings.label), 1)
    return {
        "name": _place(resources.where.embeddings),
        "pairs": len(embeddings),
        "width": embeddings.width,
        "domains": list(header.domains),
        "classes": list(header.classes),
        "counts": counts.tolist(),
        **{
            name: getattr(header, name)
            for name in ("encoder", "weights_hash", "preprocessing", "simulated", "origin")
        },
    }


def fit(resources: Resources) -> dict[str, str]:
    """Return why the first head cannot predict the set, a remedy and the command to run; each ""
    if it can.
    """
    if resources.where.frames is not None:
        return FITS
    embeddings = resources.embeddings()
    try:
        resources.head().require_embeddings(embeddings)
    except DataError as error:
        able = embeddings.learnable
        name = shlex.quote(resources.where.embeddings.name)
        return {
            "problem": without_places(str(error)),
            "remedy": REMEDY if able else UNABLE,
            "command": (
                f"python -m omnivat {f'try {name}' if able else f'report {name} --out report'}"
            ),
        }
    return FITS


def without_nan(value: Any) -> Any:
    """Return a record with None for NaN, which JSON lacks."""
    if isinstance(value, dict):
        return {key: without_nan(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [without_nan(one) for one in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def _place(path: Path) -> str:
    """Return a file's name without its folder on the server."""
    return "/".join(path.parts[-2:])


def _or_problem(
    facts: Callable[[Resources], dict[str, Any]], resources: Resources
) -> dict[str, Any]:
    try:
        return facts(resources)
    except DataError as error:
        return {"problem": without_places(str(error))}
