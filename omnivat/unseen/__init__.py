"""Results of a head in unseen domains."""

from typing import Any

from omnivat.tables import load as _load

_PUBLIC = {
    "counted": "omnivat.unseen.masks:counted",
    "unseen_domains": "omnivat.unseen.masks:unseen_domains",
    "unseen_summary": "omnivat.unseen.summary:unseen_summary",
}
__all__ = ["counted", "unseen_domains", "unseen_summary"]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'omnivat.unseen' has no attribute {name!r}")
    return _load(_PUBLIC, name, kind="public name")
