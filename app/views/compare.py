"""Compare: two orders or two stages side by side, linked: hover, lasso and zoom act on both."""

from app.components import component

TITLE = "Compare"


def build() -> None:
    """Lay the tab out. All it shows is in the frames; the browser draws them."""
    component("compare")
