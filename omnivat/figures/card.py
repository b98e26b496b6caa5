"""The lamps of sensors as a rose: from where each colour of light comes."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go

from omnivat.data.relief import Lamps
from omnivat.figures.page import Figure, figure
from omnivat.figures.specs import axis
from omnivat.kit.errors import DataError

LIGHTS = {"red": "#c2410c", "green": "#15803d", "blue": "#1d4ed8"}


def rose(sensors: Sequence[tuple[str, Lamps | None]], *, title: str) -> Figure:
    """Return a line from the middle towards each colour's light, for one sensor or several.

    sensors  name and lamps; of the last, lines are drawn thick. Without lamps one is left out

    Raises DataError if none has lamps.

    >>> import numpy as np
    >>> from omnivat.data.relief import Lamps
    >>> lit = Lamps(colours=np.array([[-9.0, 0], [4, 8], [4, -8]]), background=None, ratio=0.1,
    ...             confidence=0.99, pictures=20)
    >>> [trace.name for trace in rose([("now", lit)], title="DIGIT").data]
    ['red, now', 'green, now', 'blue, now']
    """
    known = [(name, lit) for name, lit in sensors if lit is not None]
    if not known:
        raise DataError("No lamps are known to draw; pass more touches of one sensor.")
    longest = max(float(np.linalg.norm(lit.colours, axis=1).max()) for _, lit in known)
    traces = []
    for name, lit in known:
        for (light, ink), (right, down) in zip(LIGHTS.items(), lit.colours / longest, strict=True):
            last = name == known[-1][0]
            traces.append(
                go.Scatter(
                    x=[0, -right],
                    y=[0, down],
                    mode="lines+markers",
                    name=f"{light}, {name}",
                    line={
                        "color": ink,
                        "width": 4 if last else 2,
                        "dash": "solid" if last else "dot",
                    },
                    marker={"color": ink, "size": 8 if last else 5},
                )
            )
    ends: dict[str, Any] = {"range": [-1.15, 1.15]}
    caption = (
        "A line points to where a colour's light comes from in the picture; its length is what a"
        " slope adds to that colour, beside the strongest."
    )
    return figure(
        traces,
        title=title,
        caption=caption,
        height=460,
        xaxis=axis("left to right", **ends),
        yaxis=axis("bottom to top", **ends),
    )
