"""Several small clouds of dots in rows and columns, each on axes of its own."""

from collections.abc import Mapping, Sequence
from typing import Any

import plotly.graph_objects as go

from omnivat.errors import DataError
from omnivat.figures.page import Figure, axis, figure
from omnivat.figures.theme import SERIES

ROW, GUTTER = 230, 0.07  # pixels of a row; share of the figure between two panels


def panels(rows: Sequence[Sequence[Mapping[str, Any]]], *, title: str, caption: str = "") -> Figure:
    """Return a grid of panels, readable at the width of a phone if titles are short.

    rows  {"x", "y": values of the dots, "across", and in the first of a row "up": titles of the axes}

    Raises DataError without any panel, or for a panel without dots.
    """
    cells = [(r, c, cell) for r, row in enumerate(rows) for c, cell in enumerate(row)]
    if not cells or not all(len(cell["x"]) for *_, cell in cells):
        raise DataError(f"There are no dots to draw for '{title}'.")
    wide = (1 + GUTTER) / max(map(len, rows))
    gap = 84 / (ROW * len(rows))  # titles and ticks between two rows
    high = (1 + gap) / len(rows)
    traces, layout = [], {}
    for k, (r, c, cell) in enumerate(cells):
        key = str(k + 1) if k else ""
        traces.append(
            go.Scatter(
                x=list(cell["x"]), y=list(cell["y"]), mode="markers", showlegend=False,
                marker={"color": SERIES[0], "size": 8, "opacity": 0.7}, xaxis=f"x{key}", yaxis=f"y{key}",
            )
        )  # fmt: skip
        left, top = c * wide, 1 - r * high
        layout[f"xaxis{key}"] = axis(
            cell["across"], range=_ends(cell["x"]), domain=[left, left + wide - GUTTER],
            anchor=f"y{key}", showgrid=False, nticks=3, tickangle=0, tickfont_size=11, title_font_size=11,
        )  # fmt: skip
        layout[f"yaxis{key}"] = axis(
            cell.get("up", ""), range=_ends(cell["y"]), domain=[max(0.0, top - high + gap), top],
            anchor=f"x{key}", nticks=5, title_font_size=11,
        )  # fmt: skip
    return figure(
        traces, title=title, caption=caption, height=110 + ROW * len(rows),
        showlegend=False, margin={"l": 56, "t": 64, "b": 56}, **layout,
    )  # fmt: skip


def _ends(values: Sequence[float]) -> list[float]:
    low, high = float(min(values)), float(max(values))
    room = 0.06 * (high - low or 1)
    return [low - room, high + room]
