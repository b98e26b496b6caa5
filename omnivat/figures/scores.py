"""Scores with intervals, and gaps between domains."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import plotly.graph_objects as go

from omnivat.figures.page import Figure, figure
from omnivat.figures.specs import around, axis, plain
from omnivat.figures.theme import READINGS, SERIES, SOFT
from omnivat.kit.errors import DataError
from omnivat.measure.gaps import NAMES as GAP_NAMES

READING_NAMES = {"fused": "both images", "vis": "photo only", "tac": "touch only"}
ROW = 34  # pixels of a row of dots, at least
SHARES: dict[str, Any] = {"across": "accuracy", "ends": (0, 1), "percent": True}
Record = Mapping[str, Any]


def dots(
    records: Sequence[Record],
    *,
    title: str,
    across: str,
    caption: str = "",
    level: float | None = None,
    colours: Mapping[str, str] | None = None,
    ends: tuple[float, float] | None = None,
    percent: bool = False,
) -> Figure:
    """Return a row of dots with intervals for each name: rows from the top, series side by side.

    records  {"row", "value", and if known "series", "low", "high", "note"}; a value of None is left
             out
    level    a dashed line, such as chance
    ends     of the axis; None: around the values
    percent  the values are shares

    Raises DataError without any value.

    >>> records = [
    ...     {"row": "TAG", "series": "photo", "value": 0.6, "low": 0.5, "high": 0.7},
    ...     {"row": "TAG", "series": "touch", "value": 0.4, "low": 0.3, "high": 0.5},
    ... ]
    >>> figure = dots(records, title="One sensor", across="accuracy", level=0.2, percent=True)
    >>> [(trace.name, trace.x) for trace in figure.data]
    [('photo', (0.6,)), ('touch', (0.4,))]
    """
    known = [r for r in records if r.get("value") is not None and math.isfinite(r["value"])]
    if not known:
        raise DataError(
            f"There is no value to draw for '{title}'; choose a set with labelled pairs."
        )
    rows = list(dict.fromkeys(str(r["row"]) for r in known))
    series = list(dict.fromkeys(str(r.get("series", "")) for r in known))
    traces = []
    for k, name in enumerate(series):
        own = [r for r in known if str(r.get("series", "")) == name]
        colour = (colours or {}).get(name, SERIES[k % len(SERIES)])
        shift = (k - (len(series) - 1) / 2) * 0.62 / max(2, len(series))
        values = [float(r["value"]) for r in own]
        low, high = ([_end(r, end) for r in own] for end in ("low", "high"))
        bars: dict[str, Any] = {"type": "data", "thickness": 1.6, "width": 0}
        bars["array"] = [h - v for h, v in zip(high, values, strict=True)]
        bars["arrayminus"] = [v - b for b, v in zip(low, values, strict=True)]
        traces.append(
            go.Scatter(
                x=values,
                y=[rows.index(str(r["row"])) + shift for r in own],
                name=plain(name),
                mode="markers",
                text=[_words(r, percent) for r in own],
                marker_color=colour,
                marker_size=9,
                error_x=bars,
                hoverinfo="text",
            )
        )
    every = [_end(r, end) for r in known for end in ("low", "high")] + ([level] if level else [])
    least, most = around(every, 0.04)
    span = (ends[0], 1.02 * ends[1]) if ends else (least if min(every) < 0 else 0.0, most)
    found = figure(
        traces,
        title=title,
        caption=caption,
        height=116 + max(ROW, 15 * len(series) + 8) * len(rows),
        showlegend=len(series) > 1,
        margin={"l": 24 + 7 * max(map(len, rows))},
        xaxis=axis(across, range=list(span), tickformat=".0%" if percent else None),
        yaxis=axis("", rows, range=[len(rows) - 0.5, -0.5]),
    )
    if level is not None:
        found.add_vline(level, line_color=SOFT, line_dash="dash")
    return found


def _end(record: Record, name: str) -> float:
    value = record.get(name)
    return float(record["value"] if value is None or value != value else value)


def _words(record: Record, percent: bool) -> str:
    def number(v: float) -> str:
        return f"{100 * v:.1f} %" if percent else f"{v:.4g}"

    words = f"{record['row']} {record.get('series', '')}: {number(record['value'])}"
    if record.get("low") is not None:
        words += f" [{number(_end(record, 'low'))}, {number(_end(record, 'high'))}]"
    return plain(f"{words} {record.get('note', '')}".strip())


def strangers(summary: Record) -> Figure:
    """Return the accuracy in each domain with 95 % intervals: both images, photo only, touch only.

    summary  from `omnivat.unseen_summary`, or `omnivat.measure.unseen.bars`

    >>> from omnivat import EXAMPLES, load_embeddings, load_head, unseen_summary
    >>> head = load_head(EXAMPLES / "chirps" / "head")
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> strangers(unseen_summary(head, pairs)).layout.yaxis.ticktext[-2:]
    ('Chirps D-sim', 'mean of unseen')
    """
    records = []
    for domain in (
        *summary["domains"],
        {"name": "mean of unseen", **(summary.get("unseen") or {})},
    ):
        name = domain["name"] + (" (source)" if domain.get("is_source") else "")
        for reading, words in READING_NAMES.items():
            if share := domain.get(f"answers/{reading}"):
                note = f"of {domain['pairs']} pairs" if "pairs" in domain else ""
                ends = {"low": share.get("low"), "high": share.get("high")}
                records.append(
                    {"row": name, "series": words, "value": share["share"], "note": note, **ends}
                )
    colours = {words: READINGS[name] for name, words in READING_NAMES.items()}
    caption = (
        f"Trained on {summary.get('source') or 'one domain'}. Bars: 95 % intervals. Dashed: chance."
    )
    look: dict[str, Any] = {"level": summary.get("chance"), "colours": colours, "caption": caption}
    return dots(records, title="Accuracy in each domain", **look, **SHARES)


def ladder(records: Sequence[Record]) -> Figure:
    """Return accuracy against what is known of the target, with intervals, one colour a method.

    records  {"known": words, "n": number of target pairs, "accuracy", "low", "high", "method"}

    >>> nothing = {"known": "nothing", "accuracy": 0.6, "low": 0.5, "high": 0.7, "method": "ERM"}
    >>> profile = {"known": "a profile", "n": 20, "accuracy": 0.7, "method": "ERM"}
    >>> ladder([nothing, profile]).layout.yaxis.ticktext
    ('nothing', 'a profile, 20')
    """
    rows = [f"{r['known']}, {r['n']}" if r.get("n") else str(r["known"]) for r in records]
    told = zip(rows, records, strict=True)
    rungs = [{**r, "row": row, "series": r["method"], "value": r["accuracy"]} for row, r in told]
    caption = (
        "Each row names what is known of the target, and the number of its pairs. Bars: 95 %"
        " intervals."
    )
    return dots(
        rungs, title="Accuracy against what is known of the target", caption=caption, **SHARES
    )


def gap_tables(record: Record) -> Figure:
    """Return the gap between all pairs of domains, of photos and of touches, as two tables of
    colour.

    record  as `omnivat gaps --json` prints it

    >>> table = {"A": {"A": 0.0, "B": 0.4}, "B": {"A": 0.4, "B": 0.0}}
    >>> record = {"domain_gap": {"tac": table}, "modality_gap": {"all": None}, "pairs": 8}
    >>> record |= {"measure": "centroid", "stage": "raw", "floor": {"tac": 0.1}}
    >>> gap_tables(record).data[0].text
    (['', '0.400'], ['0.400', ''])
    """
    tables = record["domain_gap"]
    names = list(next(iter(tables.values())))
    gap = record["modality_gap"]["all"]
    most = max([1e-12, *(v for t in tables.values() for row in t.values() for v in row.values())])
    digits = 2 if max(most, gap or 0) >= 1 else 3
    traces: list[Any] = []
    last = len(names) - 0.5
    layout: dict[str, Any] = {"margin": {"l": 24 + 7 * max(map(len, names)), "b": 70}}
    sides = [(m, words) for m, words in (("vis", "photos"), ("tac", "touches")) if m in tables]
    for k, (modality, words) in enumerate(sides):
        key = "2" if k else ""
        values = [[None if a == b else tables[modality][a][b] for b in names] for a in names]
        traces.append(
            go.Heatmap(
                z=values,
                zmin=0.0,
                zmax=most,
                texttemplate="%{text}",
                showscale=False,
                text=[["" if v is None else f"{v:.{digits}f}" for v in row] for row in values],
                hovertemplate=f"{words}, %{{y}} to %{{x}}: %{{text}}<extra></extra>",
                xaxis=f"x{key}",
                yaxis=f"y{key}",
            )
        )
        layout[f"xaxis{key}"] = axis(
            words,
            names,
            range=[-0.5, last],
            showgrid=False,
            domain=[0.53 * k, 0.47 + 0.53 * k] if len(sides) == 2 else [0, 1],
            tickangle=-40,
        )
        shown = {"showticklabels": False} if k else {}  # one set of names for both tables
        layout[f"yaxis{key}"] = axis(
            "", () if k else names, range=[last, -0.5], showgrid=False, anchor=f"x{key}", **shown
        )
    title = f"Between domains: {GAP_NAMES.get(record['measure'], record['measure'])}"
    caption = (
        f"At {record['stage']}, {record['pairs']}"
        f" pairs{', simulated data' if record.get('simulated') else ''}."
    )
    caption += "" if gap is None else f" Between photos and touches: {gap:.{digits}f}."
    levels = ((words, record["floor"][m]) for m, words in sides)
    level = ", ".join(f"{words} {v:.{digits}f}" for words, v in levels if v is not None)
    caption += f" Halves of one domain: {level}." if level else ""
    return figure(traces, title=title, caption=caption, height=200 + 38 * len(names), **layout)
