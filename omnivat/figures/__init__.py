"""Figures to take away, each a `plotly.graph_objects.Figure`; the one place that imports Plotly.

A figure shows itself in a notebook cell, and `write` saves it: .html (complete, opens offline in
light and dark), .svg and .png (drawn without a browser), .json (Plotly's own format). Imports
every wing below; a new figure is a function in one of its modules and its name in `_ROOMS`.
"""

from omnivat.kit.tables import late

_ROOMS = {
    "maps": ("map_figure", "frames_map", "pictures"),
    "curves": ("lines", "gap_curves", "staircase", "training_curves"),
    "scores": ("dots", "strangers", "ladder", "gap_tables"),
    "card": ("rose",),
    "surface": ("relief", "slopes"),
    "page": ("html_page", "write"),
}
_PUBLIC = {n: f"omnivat.figures.{room}:{n}" for room, names in _ROOMS.items() for n in names}
__all__ = [*_PUBLIC]
__getattr__ = late(__name__, _PUBLIC)


def __dir__() -> list[str]:
    return __all__
