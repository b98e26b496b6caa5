"""The heights of a touch, to turn in three dimensions."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go

from omnivat.figures.page import Figure, figure
from omnivat.kit.errors import DataError

MOST = 160  # points along a side: more are not seen, and slow to turn


def relief(heights: Any, *, title: str, unit: str = "relative", across: float = 1.0) -> Figure:
    """Return the heights (H, W) of a touch as a surface that can be turned; save it as .html.

    unit    of the heights, such as "mm"
    across  size of a pixel, in the same unit

    Raises DataError for another array.

    >>> hill = np.exp(-((np.mgrid[:50, :60][0] - 25) ** 2) / 40)
    >>> relief(hill, title="A ridge").data[0].z.shape
    (50, 60)
    """
    values = np.asarray(heights, float)
    if values.ndim != 2 or not np.isfinite(values).all() or min(values.shape) < 2:
        raise DataError(
            f"Heights have shape {values.shape}; pass finite numbers of (height, width), as"
            " omnivat.heights returns them."
        )
    step = -(-max(values.shape) // MOST)
    rows, columns = (np.arange(0, length, step) * across for length in values.shape)
    surface = go.Surface(
        z=values[::step, ::step], x=columns, y=rows, colorscale="Greys_r", showscale=False
    )
    drawn = figure([surface], title=title, height=520)
    names: Sequence[str] = ("right", "down", "height")
    axes = {f"{k}axis": {"title": f"{n} ({unit})"} for k, n in zip("xyz", names, strict=True)}
    axes["yaxis"]["autorange"] = "reversed"
    drawn.update_layout(scene=axes | {"aspectmode": "manual", "aspectratio": _ratio(values)})
    return drawn


def slopes(values: Any, *, title: str) -> Figure:
    """Return the slopes (H, W, 2) of a touch, to the right and downwards, as two pictures.

    >>> slopes(np.zeros((50, 60, 2)), title="Slopes").data[1].z.shape
    (50, 60)
    """
    step = -(-max(values.shape) // MOST)
    bound = float(np.quantile(np.abs(values), 0.99)) or 1.0
    shown = [
        go.Heatmap(
            z=values[::step, ::step, k],
            **{"colorscale": "RdBu_r", "zmin": -bound, "zmax": bound, "showscale": not k},
            **{"xaxis": f"x{k + 1}", "yaxis": f"y{k + 1}"},
        )
        for k in range(2)
    ]
    drawn = figure(shown, title=title, height=300)
    for k, name in enumerate(("to the right", "downwards")):
        across = {"domain": [0.52 * k, 0.48 + 0.52 * k], "title": name}
        down = {"autorange": "reversed", "scaleanchor": f"x{k + 1}", "anchor": f"x{k + 1}"}
        hidden = {"showticklabels": False, "ticks": "", "constrain": "domain"}
        drawn.update_layout({f"xaxis{k + 1}": across | hidden, f"yaxis{k + 1}": down | hidden})
    return drawn


def _ratio(values: Any) -> dict[str, float]:
    """Return the sides of the box: as wide as the picture, and a quarter as high."""
    height, width = values.shape
    return {"x": width / max(values.shape), "y": height / max(values.shape), "z": 0.25}
