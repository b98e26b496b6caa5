"""OmniVaT: single domain generalization for visual-tactile learning, as a library.

Importing this loads nothing heavy; names load on first use.
"""

from typing import Any

from omnivat.tables import load as _load

__version__ = "0.1.0"

_PUBLIC = {
    "dfrft": "omnivat.fractional:dfrft",
    "coefficients": "omnivat.fractional:coefficients",
    "synthesise": "omnivat.fractional:synthesise",
    "OmniVaT": "omnivat.model.head:OmniVaT",
    "HeadSettings": "omnivat.model.settings:HeadSettings",
    "Embeddings": "omnivat.data.store:Embeddings",
    "load_embeddings": "omnivat.data.store:load_embeddings",
    "load_head": "omnivat.checkpoint:load_head",
}
__all__ = ["__version__", *_PUBLIC]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'omnivat' has no attribute {name!r}")
    return _load(_PUBLIC, name, kind="public name")
