"""Train here: choose settings, watch a head learn, use it."""

from app.components import component

TITLE = "Train here"


def build() -> None:
    """Lay the tab out. `app.training` does the work."""
    component("train")
