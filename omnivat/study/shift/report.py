"""The report of a domain shift: one HTML page, figures as SVG, every number as CSV, the methods."""

import math
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import torch

from omnivat import figures
from omnivat.kit.files import nothing_left, path_of, write_csv, write_text
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.tables import load
from omnivat.kit.threads import one_blas_thread, one_thread
from omnivat.maps.projection import PROJECTIONS
from omnivat.maps.projection.quality import quality
from omnivat.measure.gaps import NAMES
from omnivat.measure.rungs import FEW
from omnivat.study.shift.measure import DEPTHS, NEAR, Record, gaps, neighbours, record, retrieval
from omnivat.study.shift.probe import MEASURES, probes
from omnivat.study.shift.reading import Features
from omnivat.study.shift.words import NEIGHBOURS, VIEWS, methods, notes

COLUMNS = ("part", "measure", "modality", "from", "to", "value", "low", "high", "n", "note")
MOST_ROWS = 12  # domains in a figure of dots
CHANCE = "#8593a8"  # grey in both themes
Drawn = dict[str, Any]


def write_report(
    features: Features,
    out: str | Path,
    *,
    seed: int = 0,
    more: Sequence[Record] = (),
    on_step: OnStep = ignore,
) -> list[Path]:
    """Measure, draw, and write report.html, numbers.csv, methods.txt and figures/*.svg; return
    them.

    more  further records for numbers.csv, such as those of a number that is predicted

    Raises WriteError if a file cannot be written; then none of them is left.

    >>> from tempfile import TemporaryDirectory
    >>> import numpy as np
    >>> from omnivat import read_features
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "mine.npz"
    ...     np.savez(file, tac=np.eye(12), domain=["A", "B"] * 6)
    ...     files = write_report(read_features(file), Path(folder) / "report")
    >>> [file.name for file in files if file.suffix != ".svg"]
    ['numbers.csv', 'methods.txt', 'report.html']
    """
    out = path_of(out)
    records = numbers(features, on_step)
    on_step(Step(done=0, total=0, text="maps"))
    drawn, trusts = _maps(features, seed)
    drawn |= _charts(features, records)
    records += [*trusts, *more]
    words = methods(features, seed)
    table, text, page = (out / name for name in ("numbers.csv", "methods.txt", "report.html"))
    with nothing_left(out):
        write_csv(table, COLUMNS, ([row[name] for name in COLUMNS] for row in records))
        write_text(text, words + "\n")
        files = [
            figures.write(page.parent / "figures" / f"{name}.svg", chart)
            for name, chart in drawn.items()
        ]
        write_text(page, figures.html_page("Domain shift", _page(features, records, drawn, words)))
    return [table, text, *files, page]


def numbers(features: Features, on_step: OnStep = ignore) -> list[Record]:
    """Return every number of the report but those of its maps, a record of COLUMNS each."""
    # small matrices: a second thread costs more than it helps
    with one_thread(), one_blas_thread():
        records = gaps(features, on_step)
        on_step(Step(done=0, total=0, text="retrieval and neighbours"))
        return [*records, *retrieval(features), *neighbours(features), *probes(features, on_step)]


def _maps(features: Features, seed: int) -> tuple[Drawn, list[Record]]:
    """Return UMAP by domain and by class, PCA by domain, and the trust in each map."""
    data, count = features.embeddings, len(features.embeddings)
    points = torch.cat([features.rows(name) for name in features.modalities])
    names = [name.upper() for name in features.modalities]
    drawn, records = {}, []
    hover = [
        f"{data.header.domains[d]}" + (f" · {data.header.classes[c]}" if features.labelled else "")
        for d, c in zip(data.domain, data.label, strict=True)
    ]
    for method in ("umap", "pca"):
        flat = load(PROJECTIONS, method, kind="map")(points, seed=seed)
        trust = "too few points for a trust score"
        if len(points) > 2 * NEIGHBOURS:
            score = quality(points, flat, k=NEIGHBOURS, seed=seed)
            trust = (
                f"trustworthiness {score.trustworthiness:.3f}, recall {score.recall:.3f} at"
                f" {NEIGHBOURS} neighbours"
            )
            scores = {"trustworthiness": score.trustworthiness, "recall": score.recall}
            records += [
                record("map", f"{method} {m}", value, n=len(points)) for m, value in scores.items()
            ]
        colourings = {"domain": (data.domain, data.header.domains)}
        if features.labelled and method == "umap":
            colourings["class"] = (data.label, data.header.classes)
        for colour, (group, groups) in colourings.items():
            words = {"title": f"{method.upper()} by {colour}", "hover": hover, "modalities": names}
            words["caption"] = f"{count} pairs, unit rows; {trust}. The axes have no unit"
            drawn[f"map_{method}_{colour}"] = figures.map_figure(
                flat.numpy(), group, groups, **words
            )
    return drawn, records


def _among(records: Sequence[Record], **wanted: str) -> list[Record]:
    return [r for r in records if all(r[key] == value for key, value in wanted.items())]


def _charts(features: Features, records: Sequence[Record]) -> Drawn:
    """Return the charts of a shift report by name; one without records is left out."""
    drawn: Drawn = {}
    for measure in ("centroid", "proxy_a"):
        if (table := _gap_record(features, records, measure)) is not None:
            drawn[f"gaps_{measure}"] = figures.gap_tables(table)
    depth = DEPTHS[1]
    large = {n: len(own) for n in features.domains if len(own := features.members(n)) > depth}
    ranked = _few([r for r in _among(records, measure=f"recall@{depth}") if r["modality"] in large])
    if ranked:
        rows = [{**r, "row": r["modality"], "series": f"{r['from']} to {r['to']}"} for r in ranked]
        names = dict.fromkeys(r["modality"] for r in ranked)
        rows += [{"row": n, "series": "chance", "value": depth / large[n]} for n in names]
        drawn["retrieval"] = figures.dots(
            rows,
            title=f"Own partner among the {depth} nearest",
            across=f"recall@{depth}",
            percent=True,
            colours={"chance": CHANCE},
            caption="Within each domain, by cosine. Bars: 95 % intervals over objects.",
        )
    near = _among(records, measure=f"own domain among {NEAR} nearest")
    if near:
        mixing = _few([r for r in near if r["from"]], "from")
        drawn["neighbours"] = figures.dots(
            [{**r, "row": r["from"], "series": VIEWS[r["modality"]]} for r in mixing],
            title="Neighbours from the own domain",
            across="share of the 10 nearest",
            percent=True,
            ends=(0, 1),
            level=float(near[0]["note"].split()[0]),
            caption="100 %: every neighbour is of the same domain. Dashed: the share if domains"
            " were mixed. Bars: 95 % intervals over objects.",
        )
    means = [r for r in _means(records, "probe") if r["measure"] in MEASURES]
    if means:
        drawn["probe"] = figures.dots(
            [{**r, "row": VIEWS[r["modality"]], "series": r["measure"]} for r in means],
            title="Linear maps at home and away",
            across="accuracy",
            percent=True,
            ends=(0, 1),
            caption="Home: held-out objects of the same domain. Away: mean over other domains."
            f" Profile: {FEW} pictures of the target without labels. Bars: 95 % intervals over"
            " domains.",
        )
    return drawn


def _few(records: Sequence[Record], key: str = "modality") -> list[Record]:
    """Return the records of the first MOST_ROWS domains."""
    names = list(dict.fromkeys(row[key] for row in records))[:MOST_ROWS]
    return [row for row in records if row[key] in names]


def _means(records: Sequence[Record], *parts: str) -> list[Record]:
    """Return the means of some parts: they have a note."""
    return [row for row in records if row["part"] in parts and row["note"]]


def _gap_record(
    features: Features, records: Sequence[Record], measure: str
) -> dict[str, Any] | None:
    """Return the gaps of a measure as `figures.gap_tables` takes them; None for one domain."""
    own = [r for r in _among(records, part="domain gap", measure=measure) if r["to"]]
    names = list(dict.fromkeys(n for r in own for n in (r["from"], r["to"])))
    if not names:
        return None
    tables = {m: {a: dict.fromkeys(names, 0.0) for a in names} for m in features.modalities}
    for row in own:
        a, b = row["from"], row["to"]
        tables[row["modality"]][a][b] = tables[row["modality"]][b][a] = row["value"]
    between = _means(_among(records, measure=measure), "modality gap")
    data, floors = features.embeddings, _floors(records)
    return {
        "measure": measure,
        "stage": "unit length",
        "pairs": len(data),
        "simulated": data.header.simulated,
        "modality_gap": {"all": between[0]["value"] if between else None},
        "domain_gap": tables,
        "floor": {modality: floors.get((measure, modality)) for modality in tables},
    }


def _floors(records: Sequence[Record]) -> dict[tuple[str, str], float]:
    """Return measure and modality -> the level of no gap."""
    return {(r["measure"], r["modality"]): r["value"] for r in _among(records, part="no gap")}


def _page(features: Features, records: Sequence[Record], drawn: Drawn, words: str) -> list[Any]:
    data = features.embeddings
    sizes = f"{len(features.domains)} domain{'s' * (len(features.domains) > 1)}"
    facts = (
        f"{len(data)} pairs, {sizes}: {', '.join(features.domains)}."
        + " Simulated data." * data.header.simulated
    )
    parts: list[Any] = [
        f"<p>{escape(facts)}</p>" + "".join(f"<p><b>{escape(m)}</b></p>" for m in notes(features))
    ]
    parts += [chart for name, chart in drawn.items() if name.startswith("map")]
    if gap_means := _means(records, "modality gap", "domain gap"):
        table = _gap_table(gap_means, _floors(records))
        parts += ["<h2>Gaps, means with 95 % intervals</h2>" + table]
    parts += [chart for name, chart in drawn.items() if not name.startswith("map")]
    if "probe" in drawn:
        head = ("probe of", "accuracy", "over", "mean", "95 % interval")
        cells = [
            (
                VIEWS[r["modality"]],
                r["measure"],
                r["note"].removeprefix("mean, "),
                _number(r["value"]),
                _ends(r),
            )
            for r in _means(records, "probe")
        ]
        parts += [_table(head, cells, words=3)]
    files = "<p>Every number is in numbers.csv; the figures are in figures/ as SVG.</p>"
    return [*parts, f"<h2>Methods</h2><p>{escape(words)}</p>{files}"]


def _gap_table(means: Sequence[Record], floors: dict[tuple[str, str], float]) -> str:
    cells = []
    for row in means:
        modality, measure = row["modality"], row["measure"]
        what = f"between domains, {VIEWS[modality]}" if modality else "between photos and touches"
        level = _number(floors.get((measure, modality)))
        cells.append((NAMES[measure], what, _number(row["value"]), _ends(row), level))
    head = ("measure", "gap", "mean", "95 % interval", "two halves of one domain")
    return _table(head, cells, words=2)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]], *, words: int) -> str:
    """Return a table; its first `words` columns are texts, the others numbers."""

    def line(cells: Sequence[str], tag: str) -> str:
        kinds = [' class="words"' if k < words else "" for k in range(len(cells))]
        return "".join(
            f"<{tag}{kind}>{escape(cell)}</{tag}>" for cell, kind in zip(cells, kinds, strict=True)
        )

    lines = [line(head, "th"), *(line(row, "td") for row in rows)]
    return (
        '<div class="table"><table>'
        + "".join(f"<tr>{line}</tr>" for line in lines)
        + "</table></div>"
    )


def _number(value: float | None) -> str:
    return "–" if value is None or math.isnan(value) else f"{value:.3f}"


def _ends(record: Record) -> str:
    return (
        "–" if record["low"] is None else f"{_number(record['low'])} to {_number(record['high'])}"
    )
