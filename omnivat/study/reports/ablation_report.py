"""Ablations as Markdown tables with the paper's figures, and SVG plots where it has plots."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from omnivat.data.domains import paper_name
from omnivat.figures.curves import lines
from omnivat.figures.still import svg_of
from omnivat.kit.files import write_text
from omnivat.study.ablations import Ablation, method_name
from omnivat.study.reports.intervals import Spread, spread
from omnivat.study.reports.markdown import count_text, markdown, score_cell
from omnivat.study.reports.paper import MARK, ablation_cell, not_comparable
from omnivat.study.reports.reading import (
    METRICS,
    SCORES,
    Record,
    by_run,
    by_seed,
    changed_settings,
    completed,
    latest,
    origin,
)

REPORT = "ablations.md"


def write_ablations(records: Sequence[Record], tables: Mapping[str, Ablation], folder: Path) -> str:
    """Write `ablations.md`, and a plot and its points for each figure; return the text."""
    runs = latest(records)
    if not runs:
        return "No runs yet.\n"
    full = completed(runs, method_name("full"))
    base = f" All rows start from {text}." if full and (text := changed_settings(full[0])) else ""
    words = "ACC / Macro-F1, mean over unseen targets, ± standard deviation (n − 1) over seeds."
    parts = [f"# Ablations\n\n{origin(runs)} {words}{base}"]
    run = {paper_name(r["source"]): r["source"] for r in reversed(runs)}  # simulated or not
    for name, table in tables.items():
        sources = [run.get(paper_name(source), source) for source in table.sources]
        parts += [f"## {table.title}", ablation_table(runs, name, table, sources)]
        if table.axis:
            file = f"{name}.svg"
            write_text(folder / file, ablation_plot(runs, table, sources))
            write_text(folder / f"{name}.json", ablation_points(runs, table, sources[0]))
            parts.append(f"![{table.title}]({file})")
    text = "\n\n".join(parts) + "\n"
    write_text(folder / REPORT, text)
    return text


def _spread(records: Sequence[Record], method: str, sources: Sequence[str], metric: str) -> Spread:
    """Return the spread over seeds of the mean over sources."""
    return spread(by_seed(by_run(completed(records, method), metric), sources))


def ablation_table(
    records: Sequence[Record], name: str, table: Ablation, sources: Sequence[str]
) -> str:
    """Return one ablation: one row for each variant, with our and the printed figures."""
    why = not_comparable(records[0]["data"], ablations=True)
    printed = f"printed, ViT-B/16{f' {MARK}' if why else ''}"
    rows = []
    for row, record in table.rows.items():
        runs, cells = completed(records, method_name(row)), []
        for source in sources:
            cells += [score_cell(runs, [source]), ablation_cell(name, row, source)]
        if len(sources) > 1:
            cells.append(score_cell(runs, sources))
        counts = [r["parameters"] for r in runs if r["source"] in sources]
        rows.append([record.label, *cells, count_text(counts)])
    header = ["variant", *(text for source in sources for text in (f"{source} → X", printed))]
    header += [*["average"] * (len(sources) > 1), "parameters"]
    # sources without printed figures
    full = [i for i in range(len(header)) if any(row[i] for row in rows)]
    return markdown([header[i] for i in full], [[row[i] for i in full] for row in rows])


def _placed(table: Ablation) -> dict[str, float]:
    """Return the methods of a figure's rows -> their places on its axis."""
    return {method_name(n): row.value for n, row in table.rows.items() if row.value is not None}


def ablation_plot(records: Sequence[Record], table: Ablation, sources: Sequence[str]) -> str:
    """Return the figure of one ablation: ACC and Macro-F1, mean over its sources."""
    placed, series = _placed(table), {}
    for metric in SCORES:
        spreads = [_spread(records, method, sources, metric) for method in placed]
        means, errors = ([100 * getattr(one, n) for one in spreads] for n in ("mean", "std"))
        series[METRICS[metric]] = list(map(float, range(len(placed)))), means, errors
    where = sources[0] if len(sources) == 1 else f"mean of {len(sources)} sources"
    title = f"{table.title.split(':')[0]}, {where} → X"
    ticks = [f"{value:g}" for value in placed.values()]
    return svg_of(lines(series, title=title, across=table.axis, up="%", ticks=ticks))


def ablation_points(records: Sequence[Record], table: Ablation, source: str) -> str:
    """Return {"0.5": [mean, std], …} as JSON: ACC on a source's targets over seeds, as shares."""
    spreads = {
        f"{value:g}": _spread(records, method, [source], "accuracy")
        for method, value in _placed(table).items()
    }
    points = {p: [round(s.mean, 4), round(s.std, 4)] for p, s in spreads.items() if s.std == s.std}
    return json.dumps(points) + "\n"
