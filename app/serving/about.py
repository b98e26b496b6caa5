"""What is loaded: its origin and limits."""

from collections.abc import Callable
from math import isfinite
from typing import Any

from app.pair.sensor import from_the_start
from app.shared.messages import without_places
from app.shared.resources import Resources
from app.shared.state import Reply
from omnivat.kit.errors import DataError
from omnivat.kit.schema import read_object


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


def without_nan(value: Any) -> Any:
    """Return a record with None for NaN, which JSON lacks."""
    if isinstance(value, dict):
        return {key: without_nan(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [without_nan(item) for item in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def _or_problem(facts: Callable[[Resources], Reply], resources: Resources) -> Reply:
    try:
        return facts(resources)
    except DataError as error:
        return {"problem": without_places(str(error))}
