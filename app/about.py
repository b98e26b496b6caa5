"""What is loaded: its origin and limits, and whether head and set fit."""

import shlex
from collections.abc import Callable
from math import isfinite
from typing import Any

from app.messages import without_places
from app.resources import Resources
from app.sensor import from_the_start
from app.state import Reply
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


def about(resources: Resources) -> Reply:
    """Return facts about the loaded parts; a missing part gives a sentence."""
    parts = {"head": head_facts, "embeddings": embedding_facts, "sensor": from_the_start}
    return {name: _or_problem(facts, resources) for name, facts in parts.items()}


def head_facts(resources: Resources) -> Reply:
    """Return the classes of the first head, its source, and on `real` pairs, how often it was
    correct.
    """
    head = resources.head()
    return {
        "classes": list(head.settings.classes),
        "source": head.source,
        "real": real_pairs(head.metrics),
    }


def real_pairs(metrics: Reply) -> Reply | None:
    """Return how many real pairs each reading gets right, raw and with a profile; None if a head's
    metrics have no such counts.
    """
    counts: Any = metrics.get("real")
    match counts:
        case {
            "pairs": int(),
            "always": int(),
            "as they come": {"fused": int(), "vis": int(), "tac": int()},
            "profile": {"fused": int(), "vis": int(), "tac": int()},
        }:
            return {name: counts[name] for name in ("pairs", "always", "as they come", "profile")}
    return None


def own(resources: Resources) -> Reply:
    """Return what the head for one's own pictures reads right in sensors that it has not seen; {}
    without such a head. The head is not loaded.
    """
    folder = resources.where.own
    found: dict[str, Any] = without_nan(read_object(folder / "metrics.json")) if folder else {}
    return found


def embedding_facts(resources: Resources) -> Reply:
    """Return the number of pairs of the set, its domains, and whether it is simulated."""
    embeddings = resources.embeddings()
    header = embeddings.header
    return {
        "pairs": len(embeddings),
        "domains": list(header.domains),
        "simulated": header.simulated,
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


def _or_problem(facts: Callable[[Resources], Reply], resources: Resources) -> Reply:
    try:
        return facts(resources)
    except DataError as error:
        return {"problem": without_places(str(error))}
