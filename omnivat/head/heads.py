"""Locations of the project's own heads and data."""

import json
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from omnivat.kit.files import hash_of


def _examples() -> Path:
    """Return the folder of examples: in the checkout, or in an installed `omnivat_examples`."""
    checkout = Path(__file__).resolve().parents[2] / "examples"
    installed = find_spec("omnivat_examples")
    if checkout.is_dir() or installed is None or not installed.submodule_search_locations:
        return checkout
    return Path(next(iter(installed.submodule_search_locations)))


EXAMPLES = _examples()

LADDERS = EXAMPLES / "records" / "ladder.jsonl.gz"  # of `python -m benchmarks.table --pack`
RELIEF = EXAMPLES / "records" / "relief.jsonl.gz"  # of the same with --relief

SET, HEAD = "set.safetensors", "head"  # in a folder that `omnivat try` writes
OWN = "own"  # the name of the head for one's own pictures

# Sets of the project: name -> folder of their frames and head, and embeddings file
SHIPPED = {
    "sensors": (EXAMPLES, EXAMPLES / "simulated.safetensors"),
    "chirps": (EXAMPLES / "chirps", EXAMPLES / "chirps" / "chirps.safetensors"),
}


def shipped_sets() -> dict[str, tuple[Path, Path]]:
    """Return the available sets of the project: name -> (folder, embeddings file)."""
    return {
        name: (folder, embeddings)
        for name, (folder, embeddings) in SHIPPED.items()
        if embeddings.is_file() and (folder / "head").is_dir()
    }


def default_head() -> Path:
    """Return the folder of the project's own head.

    >>> from omnivat import load_head
    >>> head = load_head(default_head())
    >>> head.source, head.settings.classes
    ('TAG-sim', ('wood', 'steel', 'plastic', 'ceramic', 'glass'))
    """
    return EXAMPLES / "head"


def own_head() -> Path:
    """Return the folder of the head for one's own pictures: it learned from all simulated
    domains.

    >>> from omnivat import load_head
    >>> load_head(own_head()).source
    'all domains'
    """
    return EXAMPLES / OWN


def head_named(text: str) -> Path:
    """Return the folder of a head; "own" is the project's head for one's own pictures, "head"
    that of one domain.
    """
    folder = Path(text)
    shipped = {OWN: own_head(), "head": default_head()}
    return folder if folder.is_dir() else shipped.get(text, folder)


def default_embeddings() -> Path:
    """Return the project's own embeddings file (simulated domains).

    >>> from omnivat import load_embeddings
    >>> pairs = load_embeddings(default_embeddings())
    >>> pairs.header.encoder, pairs.header.simulated, len(pairs.header.domains)
    ('efficientnet-lite0', True, 8)
    """
    return EXAMPLES / "simulated.safetensors"


def ladder_file(embeddings: Path) -> Path:
    """Return the path of a ladder that was computed before, next to its embeddings file."""
    return embeddings.with_suffix(".ladder.json")


def ladder_key(head: Path, embeddings: Path) -> str:
    """Return a hash of what a ladder is computed from: the head with its profile, the set and the
    records.

    Raises OSError if another file than the profile is missing: older heads have none.
    """
    profile = head / "profile.safetensors"
    own = [profile] if profile.is_file() else []
    files = (head / "weights.safetensors", head / "settings.json", *own, embeddings, LADDERS)
    return hash_of(*files)[:24]


def kept_ladder(head: Path, embeddings: Path) -> dict[str, Any] | None:
    """Return the ladder that `omnivat evaluate --ladder` wrote for exactly this head and set, or
    None.
    """
    try:
        kept = json.loads(ladder_file(embeddings).read_bytes())
        return kept["ladder"] if kept["of"] == ladder_key(head, embeddings) else None
    except (OSError, ValueError, LookupError, TypeError):
        return None
