"""Data & about: what is loaded, where it came from, its limits, and how to load one's own."""

from app.components import component

TITLE = "Data & about"


def build() -> None:
    """Lay the tab out."""
    component("data")
