"""Figures as Plotly's JSON, built without Plotly: it would cost the page's server half a second and
24 MB.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.figures.theme import CLASSES, MARK, MODALITIES, SERIES, SOFT
from omnivat.kit.errors import ShapeError

Spec = dict[str, Any]
MANY = 15_000  # from this many points on, WebGL draws them
TRAINING: dict[str, dict[str, str]] = {  # panel -> name of a line -> its value in an epoch
    "Loss": {"total": "loss", "cross-entropy": "cross_entropy"},
    "Accuracy": {"unseen domains": "accuracy/unseen", "source test": "accuracy/source_test"},
    "Unseen domains, one image": {
        "photo only": "accuracy:vis/unseen",
        "touch only": "accuracy:tac/unseen",
    },
    "Gaps of F̂": {"modality": "modality_gap/f_hat", "domain": "domain_gap/f_hat"},
    "Cosine margin of F̂": {"margin": "margin/f_hat"},
    "p": {"p": "order"},
}


def spec(
    traces: Sequence[Spec],
    *,
    title: str,
    caption: str = "",
    height: int = 420,
    pictures: Mapping[str, Any] | None = None,
    **layout: Any,
) -> Spec:
    """Return a figure as {"data", "layout"}; `layout` holds further fields of Plotly's layout.

    title, caption  plain texts, not markup
    pictures        from `omnivat.figures.pictures`: shown beside the pointer
    """
    meta = {"caption": caption, **({"pictures": dict(pictures)} if pictures else {})}
    named = {"title": {"text": plain(title)}, "height": height, "meta": meta}
    return {"data": list(traces), "layout": {**named, **layout}}


def plain(text: str) -> str:
    """Return a text without what Plotly would read as markup."""
    return str(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def around(values: Sequence[float], share: float) -> list[float]:
    """Return the ends of an axis around values, with a share of their span as room beside them."""
    low, high = (min(values), max(values)) if values else (0.0, 1.0)
    room = share * (high - low or 1)
    return [low - room, high + room]


def axis(title: str = "", ticks: Sequence[str] = (), **more: Any) -> dict[str, Any]:
    """Return an axis with labels at 0, 1, 2, ..., if any; `more` holds further fields."""
    names = {"tickvals": list(range(len(ticks))), "ticktext": [plain(name) for name in ticks]}
    named = {"showgrid": True, "zeroline": False, **(names if ticks else {})}
    return {"title": {"text": plain(title)}, **named, **more}


def known(value: float | None) -> bool:
    """Return True if there is a finite value."""
    return value is not None and math.isfinite(value)


def training_spec(
    epochs: Sequence[Mapping[str, Any]],
    *,
    total: int | None = None,
    classes: int = 0,
    columns: int = 3,
    title: str = "",
) -> Spec:
    """Return the figure of `omnivat.figures.training_curves`."""
    panels = {
        words: series
        for words, series in TRAINING.items()
        if any(known(epoch.get(key)) for epoch in epochs for key in series.values())
    }
    columns = max(1, min(columns, len(panels)))
    rows = max(1, -(-len(panels) // columns))
    wide, high = 0.16 / columns, 0.38 / rows  # between panels
    width, tall = (1 - wide * (columns - 1)) / columns, (1 - high * (rows - 1)) / rows
    data: list[Spec] = []
    notes: list[Spec] = []
    lines: list[Spec] = []
    axes: Spec = {}
    for place, (words, series) in enumerate(panels.items()):
        row, column = divmod(place, columns)
        key = str(place + 1) if place else ""
        left, low = column * (width + wide), (rows - 1 - row) * (tall + high)
        share = words.startswith(("Accuracy", "Unseen"))
        text, top = [], 0.0
        for (name, of), colour in zip(series.items(), _colours(series), strict=False):
            there = [(k, epoch[of]) for k, epoch in enumerate(epochs, 1) if known(epoch.get(of))]
            xs, ys = [k for k, _ in there], [value for _, value in there]
            line = {"color": colour, "width": 2, "dash": "dash" if "test" in name else "solid"}
            drawn = {"type": "scatter", "mode": "lines" if len(xs) > 1 else "markers"}
            at = {"xaxis": f"x{key}", "yaxis": f"y{key}"}
            data.append({**drawn, "x": xs, "y": ys, "line": line, "name": name, **at})
            top = max([top, *ys])
            value = (f"{100 * ys[-1]:.1f} %" if share else f"{ys[-1]:.3f}") if ys else "–"
            text.append(f'<span style="color:{colour}">{name}</span> {value}')
        most = 1.0 if share or words == "p" else 1.08 * top or 1.0
        form: Spec = {"exponentformat": "e", "minexponent": 4}
        if share:
            form = {"tickvals": [0, 0.5, 1], "ticktext": ["0 %", "50 %", "100 %"]}
        ends = [1, max(2, total or len(epochs))]
        across = axis(range=ends, domain=[left, left + width], anchor=f"y{key}", nticks=4)
        named = {"tickprefix": "epoch ", "showtickprefix": "first"}
        axes[f"xaxis{key}"] = across | named | {"showgrid": False}
        up = axis(range=[0, most], domain=[low, low + tall], anchor=f"x{key}", nticks=4, **form)
        axes[f"yaxis{key}"] = up
        inside = {"xref": f"x{key} domain", "yref": f"y{key} domain"}
        if classes and share:
            look = {"type": "line", "line": {"color": SOFT, "dash": "dot"}, **inside}
            level = {"x0": 0, "x1": 1, "y0": 1 / classes, "y1": 1 / classes, "yref": f"y{key}"}
            lines.append(look | level)
        corner = {"x": 0, "y": 1, "xanchor": "left", "yanchor": "bottom", "align": "left"}
        above = {"yshift": 5}  # the highest label of the axis, and of the one beside it
        words = f"<b>{words}</b><br>{'&nbsp; '.join(text)}"
        notes.append({"text": words, "showarrow": False, **corner, **above, **inside})
    margin = {"l": 44, "r": 8, "t": 50, "b": 26}
    return spec(
        data, title=title, height=44 + 196 * rows, showlegend=False, margin=margin, **axes,
        annotations=notes, shapes=lines,
    )  # fmt: skip


def _colours(series: Mapping[str, str]) -> Sequence[str]:
    return MODALITIES if "photo only" in series else [MARK] if "p" in series else SERIES


def map_spec(
    places: NDArray[Any],
    group: Sequence[int] | NDArray[Any],
    names: Sequence[str],
    *,
    title: str,
    caption: str = "",
    colours: Sequence[str] = CLASSES,
    hover: Sequence[str] | None = None,
    pictures: dict[str, Any] | None = None,
    modalities: Sequence[str] = ("VIS", "TAC"),
) -> Spec:
    """Return the figure of `omnivat.figures.map_figure`; raises as it does."""
    places = np.asarray(places, dtype=np.float64)
    rows, count = len(places), len(places) // max(1, len(modalities))
    group = np.tile(group, rows // len(group)) if len(group) else np.zeros(rows, int)
    if places.ndim != 2 or places.shape[1] not in (2, 3) or len(group) != rows or not rows:
        raise ShapeError(
            f"places has shape {places.shape} and group {np.shape(group)}; a map needs (M N, 2) or "
            "(M N, 3), and N or M N groups."
        )
    traces = []
    deep = places.shape[1] == 3
    kind = "scatter3d" if deep else "scattergl" if rows > MANY else "scatter"
    symbols = ("circle", "diamond" if deep else "triangle-up")  # no triangle in three dimensions
    for k, modality in enumerate(modalities):
        first = k * count
        for index, name in enumerate(map(plain, names)):
            own = np.flatnonzero(group[first : first + count] == index).tolist()
            if not own:
                continue
            trace: Spec = {
                "type": kind,
                "mode": "markers",
                "name": name,
                "legendgroup": name,
                "showlegend": not np.any(group[:first] == index),
                "marker": {
                    "color": colours[index % len(colours)],
                    "size": 3 if deep else 6,
                    "opacity": 0.75,
                    "symbol": symbols[k],
                },
                "hoverinfo": "name" if hover is None else "text",
            }
            if hover is not None:
                trace["text"] = [f"{modality} · {plain(hover[i])}" for i in own]
            if pictures:
                trace["customdata"] = [[i, i + count][: len(modalities)] for i in own]
            at = np.round(places[first:][own], 4).T.tolist()
            traces.append(trace | dict(zip("xyz", at, strict=False)))
    shapes = "Circle: photo (VIS); triangle: touch (TAC)" if len(modalities) == 2 else ""
    words = ". ".join(part for part in (caption.rstrip("."), shapes) if part) + "."
    return spec(traces, title=title, caption=words, height=620, pictures=pictures, **_axes(places))


def _axes(places: NDArray[Any]) -> dict[str, Any]:
    if places.shape[1] == 3:
        bare = {"title": {"text": ""}, "showticklabels": False}
        scene = {f"{k}axis": bare for k in "xyz"} | {"aspectmode": "data"}
        return {"scene": scene, "margin": {"l": 0, "r": 0, "t": 44, "b": 0}}
    middle = (places.max(0) + places.min(0)) / 2
    half = 1.04 * max(float((places.max(0) - places.min(0)).max()) / 2, 1e-9)
    across, up = ([float(m - half), float(m + half)] for m in middle)
    return {
        "xaxis": {"range": across, "visible": False, "constrain": "domain"},
        "yaxis": {"range": up, "visible": False, "scaleanchor": "x", "constrain": "domain"},
        "margin": {"l": 12, "r": 12, "t": 44, "b": 12},
        "dragmode": "pan",
    }
