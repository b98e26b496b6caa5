"""Curves: any lines, measures against p, the staircase of stages."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import plotly.graph_objects as go

from omnivat.figures.page import Figure, axis, figure, plain
from omnivat.figures.theme import ACCENT, AREA, MARK, SERIES, SOFT
from omnivat.kit.stages import STAGE_TITLES
from omnivat.maps.frames.records import FrameSet

MEASURES = {
    "modality_gap": "Modality gap",
    "domain_gap": "Domain gap",
    "accuracy": "Unseen accuracy",
    "margin": "Cosine margin",
}
BOXES = [(0.0, 0.64), (0.56, 0.64), (0.0, 0.0), (0.56, 0.0)]  # left and lower end of four charts
Values = Sequence[float | None]


def lines(
    series: Mapping[str, tuple[Sequence[float], Values] | tuple[Sequence[float], Values, Values]],
    *,
    title: str,
    across: str = "",
    up: str = "",
    ticks: Sequence[str] = (),
    caption: str = "",
    height: int = 380,
) -> Figure:
    """Return lines with markers: name -> (places, values) or (places, values, half error bars).

    across, up  titles of the axes
    ticks       labels of the places 0, 1, 2, ...; none: the places are numbers

    >>> series = {"OmniVaT": ([0.0, 0.5, 1.0], [0.52, 0.55, 0.53])}
    >>> figure = lines(series, title="Accuracy in unseen domains", across="p")
    >>> figure.data[0].name, figure.data[0].y
    ('OmniVaT', (0.52, 0.55, 0.53))
    """
    traces, ends, places = [], [], []
    for index, (name, (xs, ys, *errors)) in enumerate(series.items()):
        bars = [0.0 if e is None or e != e else float(e) for e in errors[0]] if errors else None
        known = [(y, b) for y, b in zip(ys, bars or [0.0] * len(ys), strict=True) if _is(y)]
        ends += [float(y) + sign * b for y, b in known if y is not None for sign in (-1, 1)]
        places += list(xs)
        colour = {"color": SERIES[index % len(SERIES)]}
        look: dict[str, Any] = {
            "mode": "lines+markers",
            "line": colour,
            "marker": colour | {"size": 6},
        }
        look["error_y"] = {"array": bars} if bars else None
        traces.append(
            go.Scatter(x=list(xs), y=[y if _is(y) else None for y in ys], name=plain(name), **look)
        )
    marks = {"tickvals": list(range(len(ticks))), "ticktext": [plain(t) for t in ticks]}
    low, high = (min(ends), max(ends)) if ends else (0.0, 1.0)
    room = 0.05 * (high - low or 1)
    left, right = (min(places), max(places)) if places else (0.0, 1.0)
    side = 0.03 * (right - left or 1)
    xaxis = axis(across, range=[left - side, right + side], **(marks if ticks else {}))
    yaxis = axis(up, range=[low - room, high + room])
    layout: dict[str, Any] = {"xaxis": xaxis, "yaxis": yaxis, "hovermode": "x unified"}
    return figure(traces, title=title, caption=caption, height=height, **layout)


def _is(value: float | None) -> bool:
    return value is not None and math.isfinite(value)


def gap_curves(frames: FrameSet, *, stage: str = "f_hat", order: float | None = None) -> Figure:
    """Return both gaps, accuracy and margin over p on fixed axes, with `order` marked.

    order  quarter turns; None: the learned one

    For fixed weights, a pale band shows the orders that the head was trained for. For retrained
    heads, it spans the lowest to the highest training, and dots mark the stops.
    """
    learned = frames.head.get("learned_order")
    at = order if order is not None else float(learned or 0.5)
    traces: list[Any] = []
    layout: dict[str, Any] = {}
    shapes: list[dict[str, Any]] = []
    notes: list[dict[str, Any]] = []
    for k, (name, words) in enumerate(MEASURES.items()):
        key, most = str(k + 1) if k else "", _highest(frames, name)
        left, low = BOXES[k]
        span = [frames.orders[0], frames.orders[-1]]
        layout[f"xaxis{key}"] = axis(
            domain=[left, left + 0.44], anchor=f"y{key}", range=span, showgrid=False
        )
        layout[f"yaxis{key}"] = axis(
            domain=[low, low + 0.36], anchor=f"x{key}", range=[0, most], nticks=5
        )
        here = {"xref": f"x{key}", "yref": f"y{key}"}
        upright = {"xref": f"x{key}", "yref": f"y{key} domain", "y0": 0, "y1": 1}
        fits = frames.head.get("fits")
        if frames.head.get("kind", "moved") == "moved" and fits is not None:
            ends = {"x0": max(span[0], fits[0]), "x1": min(span[1], fits[1])}
            if ends["x0"] < ends["x1"]:
                shapes.append(
                    {"type": "rect", "fillcolor": AREA, "line_width": 0, **upright, **ends}
                )
        raw = frames.curves.get(f"{name}/raw") or [None]
        level = 1 / len(frames.classes) if name == "accuracy" else raw[0]
        if level is not None:
            ends = {"x0": span[0], "x1": span[1], "y0": level, "y1": level}
            shapes.append({"type": "line", "line": {"color": SOFT, "dash": "dash"}, **here, **ends})
        shapes.append(
            {"type": "line", "line": {"color": MARK, "width": 1}, **upright, "x0": at, "x1": at}
        )
        traces += _chart(frames, name, words, stage, {"xaxis": f"x{key}", "yaxis": f"y{key}"})
        place = {
            "xref": f"x{key} domain",
            "yref": f"y{key} domain",
            "x": 0,
            "y": 1,
            "showarrow": False,
        }
        place |= {"xanchor": "left", "yanchor": "bottom", "align": "left"}
        notes.append({"text": f"{words}<br>{_value_at(frames, name, stage, at)}", **place})
    title = f"OmniVaT, {STAGE_TITLES.get(stage, stage)}, against p"
    layout |= {
        "shapes": shapes,
        "annotations": notes,
        "showlegend": False,
        "margin": {"t": 88, "b": 32},
    }
    return figure(traces, title=title, caption=_caption(frames), height=560, **layout)


def _chart(
    frames: FrameSet, name: str, words: str, stage: str, axes: Mapping[str, str]
) -> list[Any]:
    """Return the span of several trainings, if any, and the curve."""
    traces, kind = [], frames.head.get("kind", "moved")
    stem = "seeds:accuracy/unseen" if name == "accuracy" else f"seeds:{name}/{stage}"
    low, high = (frames.curves.get(f"{stem}/{end}") for end in ("low", "high"))
    if low is not None and high is not None:
        there = [k for k, (a, b) in enumerate(zip(low, high, strict=True)) if _is(a) and _is(b)]
        around = [*there, *reversed(there)]
        ends = [(low if i < len(there) else high)[k] for i, k in enumerate(around)]
        pale = {
            "fill": "toself",
            "fillcolor": AREA,
            "line_width": 0,
            "mode": "lines",
            "hoverinfo": "skip",
        }
        traces.append(go.Scatter(x=[frames.orders[k] for k in around], y=ends, **pale, **axes))
    own = _curve(frames, name, stage)
    if own is not None:
        look: dict[str, Any] = {
            "mode": "lines+markers" if kind == "retrained" else "lines",
            "marker": {"size": 5, "color": ACCENT},
        }
        look["line_color"] = SOFT if kind == "moved" else ACCENT  # fixed weights: a what-if
        traces.append(go.Scatter(x=list(frames.orders), y=list(own), name=words, **look, **axes))
    return traces


def _curve(frames: FrameSet, name: str, stage: str) -> Values | None:
    """Return the values of a measure at a stage; accuracy excludes training pairs."""
    if name != "accuracy":
        return frames.curves.get(f"{name}/{stage}")
    retrained = frames.head.get("kind") == "retrained"
    return frames.curves.get("seeds:accuracy/unseen/mean" if retrained else "accuracy/unseen")


def _value_at(frames: FrameSet, name: str, stage: str, order: float) -> str:
    own = _curve(frames, name, stage)
    known = [(p, v) for p, v in zip(frames.orders, own or (), strict=False) if v is not None]
    if not known:
        return "not measured"
    p, v = min(known, key=lambda piece: abs(piece[0] - order))
    return f"{100 * v:.1f} % at p = {p:.3g}" if name == "accuracy" else f"{v:.3f} at p = {p:.3g}"


def _highest(frames: FrameSet, name: str) -> float:
    """Return the upper limit of a measure over all stages and stops."""
    if name == "accuracy":
        return 1.0
    found = [values for key, values in frames.curves.items() if key.startswith(f"{name}/")]
    return 1.02 * max([0.1, *(v for values in found for v in values if v is not None)])


def _caption(frames: FrameSet) -> str:
    source, learned = frames.head.get("source"), frames.head.get("learned_order")
    parts = ["Simulated data" if frames.embeddings.get("simulated") else "Real data"]
    parts += [f"trained on {source}"] if source else []
    kind = frames.head.get("kind", "moved")
    if kind == "retrained":
        parts.append("each stop is a head trained at that p")
    elif kind == "every":
        parts.append("one head trained for every p")
    elif learned is not None:
        parts.append(f"weights are those of the learned p = {learned:.3f}: elsewhere a what-if")
    return "; ".join(parts) + ". Dashed: the raw embedding, or chance."


def staircase(frames: FrameSet, *, order: float | None = None) -> Figure:
    """Return both gaps and the margin at each stage of the head, at the stop nearest to `order`."""
    at = order if order is not None else float(frames.head.get("learned_order") or 0.5)
    stop = min(range(len(frames.orders)), key=lambda i: abs(frames.orders[i] - at))
    traces, words = [], list(STAGE_TITLES.values())
    edges = [x for k in range(len(words)) for x in (k - 0.5, k + 0.5)]
    measures = ("modality_gap", "domain_gap", "margin")
    for name, colour in zip(measures, SERIES, strict=False):
        values = [frames.curves.get(f"{name}/{stage}") for stage in STAGE_TITLES]
        steps = [None if v is None else v[stop] for v in values for _ in range(2)]
        line = {"color": colour, "width": 3}
        traces.append(go.Scatter(x=edges, y=steps, name=MEASURES[name], mode="lines", line=line))
    most = max(_highest(frames, name) for name in measures)
    # the angle leaves room for all names, on a phone, too
    ticks: dict[str, Any] = {
        "tickvals": list(range(len(words))),
        "ticktext": words,
        "tickangle": -35,
    }
    return figure(
        traces,
        title=f"Gaps at each step, p = {frames.orders[stop]:.2f}",
        caption=_caption(frames).replace(" Dashed: the raw embedding, or chance.", ""),
        xaxis=axis(range=[-0.5, len(words) - 0.5], showgrid=False, **ticks),
        yaxis=axis("gap or margin", range=[0, most]),
        hovermode="x unified",
    )
