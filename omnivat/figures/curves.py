"""Curves: any lines, measures against p, the staircase of stages."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from omnivat.figures.page import Figure, figure, made
from omnivat.figures.specs import around, axis, known, plain, training_spec
from omnivat.figures.theme import ACCENT, AREA, MARK, SERIES, SOFT
from omnivat.kit.stages import STAGE_TITLES
from omnivat.maps.frames.records import FrameSet

MEASURES = {
    "modality_gap": "Modality gap",
    "domain_gap": "Domain gap",
    "accuracy": "Unseen accuracy",
    "margin": "Cosine margin",
}
# by the kind of frames: what p does, as "can" and "caption" of a row of the page's modes
KINDS: dict[str, dict[str, Any]] = {
    "moved": {
        "can": ("what-if",),
        "caption": "weights are those of the learned p = {learned}: elsewhere a what-if",
    },
    "retrained": {"can": ("heads",), "caption": "each stop is a head trained at that p"},
    "every": {"can": (), "caption": "one head trained for every p"},
}
Mode = dict[str, Any]
Values = Sequence[float | None]


def lines(
    series: Mapping[str, tuple[Sequence[float], Values] | tuple[Sequence[float], Values, Values]],
    *,
    title: str,
    across: str = "",
    up: str = "",
    ticks: Sequence[str] = (),
    caption: str = "",
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
        there = [(y, b) for y, b in zip(ys, bars or [0.0] * len(ys), strict=True) if known(y)]
        ends += [float(y) + sign * b for y, b in there if y is not None for sign in (-1, 1)]
        places += list(xs)
        colour = SERIES[index % len(SERIES)]
        traces.append(
            go.Scatter(
                x=list(xs),
                y=[y if known(y) else None for y in ys],
                name=plain(name),
                mode="lines+markers",
                line_color=colour,
                marker_color=colour,
                marker_size=6,
                error_y={"array": bars} if bars else None,
            )
        )
    return figure(
        traces,
        title=title,
        caption=caption,
        height=380,
        xaxis=axis(across, ticks, range=around(places, 0.03)),
        yaxis=axis(up, range=around(ends, 0.05)),
        hovermode="x unified",
    )


def training_curves(
    epochs: Sequence[Mapping[str, Any]],
    *,
    total: int | None = None,
    classes: int = 0,
    columns: int = 3,
    title: str = "",
) -> Figure:
    """Return losses, accuracies, gaps and p over the epochs of a training; a panel without values
    is left out.

    epochs   records of epochs, as `head.metrics["epochs"]` or `maps.epochs.reporter` has them
    total    epochs of the whole training; None: those that are there
    classes  number of classes: a dotted line shows the accuracy of guessing

    >>> from omnivat import default_head, load_head
    >>> figure = training_curves(load_head(default_head()).metrics["epochs"])
    >>> [words.text.split("<br>")[0] for words in figure.layout.annotations]
    ['<b>Loss</b>', '<b>p</b>']
    """
    return made(training_spec(epochs, total=total, classes=classes, columns=columns, title=title))


def gap_curves(
    frames: FrameSet,
    *,
    stage: str = "f_hat",
    name: str | None = None,
    order: float | None = None,
    mode: Mode | None = None,
) -> Figure:
    """Return both gaps, accuracy and margin over p on fixed axes, with `order` marked.

    name   of the stage in the title; None: as in STAGE_TITLES
    order  quarter turns; None: the learned one
    mode   "can" and "caption" of a kind of frames that is not in KINDS

    For fixed weights, a pale band shows the orders that the head was trained for. Of several
    trainings, it spans the lowest to the highest, and where each stop has a head, dots mark them.

    >>> from omnivat import EXAMPLES, read_frames
    >>> figure = gap_curves(read_frames(EXAMPLES / "chirps" / "frames.bin"), order=0.35)
    >>> [words.text.split("<br>")[0] for words in figure.layout.annotations]
    ['Modality gap', 'Domain gap', 'Unseen accuracy', 'Cosine margin']
    """
    mode = _mode(frames, mode)
    learned = frames.head.get("learned_order")
    at = order if order is not None else float(learned or 0.5)
    title = f"OmniVaT, {name or STAGE_TITLES[stage]}, against p"
    look: dict[str, Any] = {"showlegend": False, "margin": {"t": 88, "b": 32}, "height": 560}
    caption = f"{_caption(frames, mode)} Dashed: the raw embedding, or chance."
    drawn = figure([], title=title, caption=caption, **look)
    make_subplots(2, 2, horizontal_spacing=0.12, vertical_spacing=0.28, figure=drawn)
    span = frames.orders[0], frames.orders[-1]
    fits = frames.head.get("fits") if "what-if" in mode["can"] else None
    low, high = np.clip(fits or (0.0, 0.0), *span).tolist()
    for k, (measure, words) in enumerate(MEASURES.items()):
        chart = {"row": k // 2 + 1, "col": k % 2 + 1}
        drawn.add_traces(_chart(frames, measure, words, stage, mode), chart["row"], chart["col"])
        drawn.update_xaxes(axis(range=list(span), showgrid=False), **chart)
        drawn.update_yaxes(axis(range=[0, _highest(frames, measure)], nticks=5), **chart)
        every = {"exclude_empty_subplots": False, **chart}
        if low < high:
            drawn.add_vrect(low, high, fillcolor=AREA, line_width=0, **every)
        raw = frames.curves.get(f"{measure}/raw") or [None]
        level = 1 / len(frames.classes) if measure == "accuracy" else raw[0]
        if level is not None:
            drawn.add_hline(level, line_color=SOFT, line_dash="dash", **every)
        drawn.add_vline(at, line_color=MARK, line_width=1, **every)
        place = {"xref": "x domain", "yref": "y domain", "x": 0, "y": 1, "align": "left"}
        drawn.add_annotation(
            text=f"{words}<br>{_value_at(frames, measure, stage, at)}",
            showarrow=False,
            xanchor="left",
            yanchor="bottom",
            **place,
            **chart,
        )
    return drawn


def _mode(frames: FrameSet, mode: Mode | None) -> Mode:
    """Return what p does in frames; of a kind that nobody describes, its name."""
    kind = str(frames.head.get("kind", "moved"))
    return {"can": (), "caption": kind} | (KINDS.get(kind) or mode or {})


def _chart(frames: FrameSet, name: str, words: str, stage: str, mode: Mode) -> list[Any]:
    """Return the span of several trainings, if any, and the curve."""
    traces: list[Any] = []
    stem = "seeds:accuracy/unseen" if name == "accuracy" else f"seeds:{name}/{stage}"
    low, high = (frames.curves.get(f"{stem}/{end}") for end in ("low", "high"))
    if low is not None and high is not None:
        ends = zip(frames.orders, low, high, strict=True)
        band = [(p, a, b) for p, a, b in ends if known(a) and known(b)]
        outline = [(p, a) for p, a, _ in band] + [(p, b) for p, _, b in reversed(band)]
        traces.append(
            go.Scatter(
                x=[p for p, _ in outline],
                y=[value for _, value in outline],
                fill="toself",
                fillcolor=AREA,
                line_width=0,
                mode="lines",
                hoverinfo="skip",
            )
        )
    own = _curve(frames, name, stage)
    if own is not None:
        traces.append(
            go.Scatter(
                x=list(frames.orders),
                y=list(own),
                name=words,
                marker_size=5,
                marker_color=ACCENT,
                mode="lines+markers" if "heads" in mode["can"] else "lines",
                line_color=SOFT if "what-if" in mode["can"] else ACCENT,
            )
        )
    return traces


def _curve(frames: FrameSet, name: str, stage: str) -> Values | None:
    """Return the values of a measure at a stage; accuracy excludes training pairs, and is the mean
    of several trainings.
    """
    names = [f"{name}/{stage}"]
    if name == "accuracy":
        names = ["seeds:accuracy/unseen/mean", "accuracy/unseen"]
    return next((frames.curves[name] for name in names if name in frames.curves), None)


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


def _caption(frames: FrameSet, mode: Mode) -> str:
    source, learned = frames.head.get("source"), frames.head.get("learned_order")
    parts = ["Simulated data" if frames.embeddings.get("simulated") else "Real data"]
    parts += [f"trained on {source}"] if source else []
    words = str(mode["caption"])
    if learned is not None or "{learned}" not in words:
        parts.append(words.replace("{learned}", f"{learned or 0:.3f}"))
    return "; ".join(parts) + "."


def staircase(frames: FrameSet, *, order: float | None = None, mode: Mode | None = None) -> Figure:
    """Return both gaps and the margin at each stage of the head, at the stop nearest to `order`;
    `mode` as in `gap_curves`.

    >>> from omnivat import EXAMPLES, read_frames
    >>> figure = staircase(read_frames(EXAMPLES / "chirps" / "frames.bin"), order=0.35)
    >>> figure.layout.title.text, [trace.name for trace in figure.data]
    ('Gaps at each step, p = 0.35', ['Modality gap', 'Domain gap', 'Cosine margin'])
    """
    at = order if order is not None else float(frames.head.get("learned_order") or 0.5)
    stop = min(range(len(frames.orders)), key=lambda i: abs(frames.orders[i] - at))
    traces, words = [], list(STAGE_TITLES.values())
    edges = [x for k in range(len(words)) for x in (k - 0.5, k + 0.5)]
    measures = ("modality_gap", "domain_gap", "margin")
    for name, colour in zip(measures, SERIES, strict=False):
        values = [frames.curves.get(f"{name}/{stage}") for stage in STAGE_TITLES]
        steps = [None if v is None else v[stop] for v in values for _ in range(2)]
        look = {"mode": "lines", "line_color": colour, "line_width": 3}
        traces.append(go.Scatter(x=edges, y=steps, name=MEASURES[name], **look))
    most = max(_highest(frames, name) for name in measures)
    return figure(
        traces,
        title=f"Gaps at each step, p = {frames.orders[stop]:.2f}",
        caption=_caption(frames, _mode(frames, mode)),
        # the angle leaves room for all names, on a phone, too
        xaxis=axis("", words, range=[-0.5, len(words) - 0.5], showgrid=False, tickangle=-35),
        yaxis=axis("gap or margin", range=[0, most]),
        hovermode="x unified",
    )
