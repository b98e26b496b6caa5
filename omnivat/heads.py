"""Locations of the project's own heads and data."""

from importlib.util import find_spec
from pathlib import Path


def _examples() -> Path:
    """Return the folder of examples: in the checkout, or in an installed `omnivat_examples`."""
    checkout = Path(__file__).resolve().parent.parent / "examples"
    installed = find_spec("omnivat_examples")
    if checkout.is_dir() or installed is None or not installed.submodule_search_locations:
        return checkout
    return Path(next(iter(installed.submodule_search_locations)))


EXAMPLES = _examples()

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
    """Return the folder of the project's own head."""
    return EXAMPLES / "head"


def default_embeddings() -> Path:
    """Return the project's own embeddings file (simulated domains)."""
    return EXAMPLES / "simulated.safetensors"
