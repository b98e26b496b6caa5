"""Where heads and the data that come with the project live."""

from pathlib import Path

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"


def default_head() -> Path:
    """Return the folder of the head that comes with the project."""
    return EXAMPLES / "head"


def default_embeddings() -> Path:
    """Return the embeddings file that comes with the project (simulated domains)."""
    return EXAMPLES / "simulated.safetensors"
