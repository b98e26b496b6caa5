"""Tree: the nodes that DTG grows from the chosen pair, and what NOD keeps apart."""

from app.components import component

TITLE = "Tree"


def build() -> None:
    """Lay the tab out."""
    component("tree")
