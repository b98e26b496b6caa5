"""OmniVaT: single domain generalization for visual-tactile learning, as a library.

Importing this loads nothing heavy; names load on first use.
"""

from omnivat.kit.tables import late

__version__ = "0.1.0"

_PUBLIC = {
    "dfrft": "omnivat.fractional:dfrft",
    "coefficients": "omnivat.fractional:coefficients",
    "synthesise": "omnivat.fractional:synthesise",
    "OmniVaT": "omnivat.head.head:OmniVaT",
    "HeadSettings": "omnivat.head.settings:HeadSettings",
    "Embeddings": "omnivat.data.store:Embeddings",
    "load_embeddings": "omnivat.data.store:load_embeddings",
    "load_head": "omnivat.head.checkpoint:load_head",
    "twins": "omnivat.measure.twins:twins",
}
__all__ = ["__version__", *_PUBLIC]
__getattr__ = late(__name__, _PUBLIC)
