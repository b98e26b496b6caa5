"""The report of a domain shift: one HTML page, figures as SVG, every number as CSV, the methods."""

import math
import platform
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import torch

from omnivat import __version__, figures
from omnivat.files import write_csv, write_text
from omnivat.gaps import GAPS
from omnivat.progress import OnStep, Step, ignore
from omnivat.projection import PROJECTIONS
from omnivat.projection.quality import quality
from omnivat.shift.measure import (
    DEPTHS,
    LEAST,
    MOST_DOMAINS,
    Record,
    gaps,
    neighbours,
    record,
    retrieval,
)
from omnivat.shift.probe import FOLDS, PROFILE, probes
from omnivat.shift.reading import Features
from omnivat.tables import load
from omnivat.threads import one_blas_thread, one_thread

COLUMNS = ("part", "measure", "modality", "from", "to", "value", "low", "high", "n", "note")
NEIGHBOURS = 15  # of the trust in a map
VIEWS = {"vis": "photos", "tac": "touches", "both": "both", "": "photo to touch"}
MOST_ROWS = 12  # domains in a figure of dots
Drawn = dict[str, Any]


def write_report(
    found: Features, out: Path, *, seed: int = 0, on_step: OnStep = ignore
) -> list[Path]:
    """Measure, draw, and write report.html, numbers.csv, methods.txt and figures/*.svg; return them.

    Raises WriteError if a file cannot be written. Each file is complete or absent.
    """
    records = numbers(found, on_step)
    on_step(Step(done=0, total=0, text="maps"))
    drawn, trusts = _maps(found, seed)
    drawn |= _charts(found, records)
    records += trusts
    words = methods(found, seed)
    files = [out / "numbers.csv", out / "methods.txt"]
    write_csv(files[0], COLUMNS, ([one[name] for name in COLUMNS] for one in records))
    write_text(files[1], words + "\n")
    for name, one in drawn.items():
        files.append(figures.write(out / "figures" / f"{name}.svg", one))
    page = figures.html_page("Domain shift", _page(found, records, drawn, words))
    write_text(out / "report.html", page)
    return [*files, out / "report.html"]


def numbers(found: Features, on_step: OnStep = ignore) -> list[Record]:
    """Return every number of the report but those of its maps, a record of COLUMNS each."""
    with (
        one_thread(),
        one_blas_thread(),
    ):  # small matrices: a second thread costs more than it helps
        records = gaps(found, on_step)
        on_step(Step(done=0, total=0, text="retrieval and neighbours"))
        return [*records, *retrieval(found), *neighbours(found), *probes(found, on_step)]


def _maps(found: Features, seed: int) -> tuple[Drawn, list[Record]]:
    """Return UMAP by domain and by class, PCA by domain, and the trust in each map."""
    data, count = found.embeddings, len(found.embeddings)
    points = torch.cat([found.rows(name) for name in found.modalities])
    names = [name.upper() for name in found.modalities]
    drawn, records = {}, []
    hover = [
        f"{data.header.domains[d]}" + (f" · {data.header.classes[c]}" if found.labelled else "")
        for d, c in zip(data.domain, data.label, strict=True)
    ]
    for method in ("umap", "pca"):
        flat = load(PROJECTIONS, method, kind="map")(points, seed=seed)
        trust = "too few points for a trust score"
        if len(points) > 2 * NEIGHBOURS:
            score = quality(points, flat, k=NEIGHBOURS, seed=seed)
            trust = f"trustworthiness {score.trustworthiness:.3f}, recall {score.recall:.3f} at {NEIGHBOURS} neighbours"
            for measure in ("trustworthiness", "recall"):
                records.append(
                    record("map", f"{method} {measure}", getattr(score, measure), n=len(points))
                )
        colourings = {"domain": (data.domain, data.header.domains)}
        if found.labelled and method == "umap":
            colourings["class"] = (data.label, data.header.classes)
        for colour, (group, groups) in colourings.items():
            drawn[f"map_{method}_{colour}"] = figures.map_figure(
                flat.numpy(),
                group,
                groups,
                title=f"{method.upper()} by {colour}",
                caption=f"{count} pairs, unit rows; {trust}. The axes have no unit",
                hover=hover,
                modalities=names,
            )
    return drawn, records


def _charts(found: Features, records: Sequence[Record]) -> Drawn:
    """Return the figures of the numbers."""
    drawn: Drawn = {}
    for measure in ("centroid", "proxy_a"):
        table = _gap_record(found, records, measure)
        if table is not None:
            drawn[f"gaps_{measure}"] = figures.gap_tables(table)
    chosen = [
        r for r in records if r["part"] == "retrieval" and r["measure"] == f"recall@{DEPTHS[1]}"
    ]
    if chosen:
        rows = [
            {**r, "row": r["modality"], "series": f"{r['from']} to {r['to']}"}
            for r in _few(chosen, "modality")
        ]
        drawn["retrieval"] = figures.dots(
            rows,
            title=f"Own partner among the {DEPTHS[1]} nearest",
            across=f"recall@{DEPTHS[1]}",
            percent=True,
            caption="Within each domain, by cosine. Bars: 95 % intervals over objects. Chance differs with the size of the domain and is in numbers.csv.",
        )
    mixing = [
        r
        for r in records
        if r["part"] == "neighbours" and "own domain" in r["measure"] and r["from"]
    ]
    if mixing:
        level = next(r for r in records if r["part"] == "neighbours" and "if domains" in r["note"])
        drawn["neighbours"] = figures.dots(
            [{**r, "row": r["from"], "series": VIEWS[r["modality"]]} for r in _few(mixing, "from")],
            title="Neighbours from the own domain",
            across="share of the 10 nearest",
            percent=True,
            ends=(0, 1),
            level=float(level["note"].split()[0]),
            caption="1: every neighbour is of the same domain. Dashed: the share if domains were mixed. Bars: 95 % intervals over objects.",
        )
    order = ("home", "away", "away, with a profile")
    means = [r for r in records if r["part"] == "probe" and r["note"] and r["measure"] in order]
    if means:
        drawn["probe"] = figures.dots(
            [{**r, "row": VIEWS[r["modality"]], "series": r["measure"]} for r in means],
            title="A linear probe at home and away",
            across="accuracy",
            percent=True,
            ends=(0, 1),
            caption=f"Home: held-out objects of the same domain. Away: mean over other domains. Profile: {PROFILE} pictures of the target without labels. Bars: 95 % intervals over domains.",
        )
    return drawn


def _few(records: Sequence[Record], key: str) -> list[Record]:
    """Return the records of the first domains; the table holds all."""
    names = list(dict.fromkeys(one[key] for one in records))[:MOST_ROWS]
    return [one for one in records if one[key] in names]


def _gap_record(found: Features, records: Sequence[Record], measure: str) -> dict[str, Any] | None:
    """Return the gaps of a measure as `figures.gap_tables` takes them; None for one domain."""
    own = [r for r in records if r["part"] == "domain gap" and r["measure"] == measure and r["to"]]
    names = list(dict.fromkeys(n for r in own for n in (r["from"], r["to"])))
    if not names:
        return None
    tables = {m: {a: dict.fromkeys(names, 0.0) for a in names} for m in found.modalities}
    for one in own:
        a, b = one["from"], one["to"]
        tables[one["modality"]][a][b] = tables[one["modality"]][b][a] = one["value"]
    between = [
        r for r in records if r["part"] == "modality gap" and r["measure"] == measure and r["note"]
    ]
    return {
        "measure": measure,
        "stage": "unit rows",
        "pairs": len(found.embeddings),
        "simulated": found.embeddings.header.simulated,
        "modality_gap": {"all": between[0]["value"] if between else None},
        "domain_gap": tables,
    }


def _page(found: Features, records: Sequence[Record], drawn: Drawn, words: str) -> list[Any]:
    data = found.embeddings
    facts = f"{len(data)} pairs, {len(found.domains)} domains: {', '.join(found.domains)}."
    if data.header.simulated:
        facts += " Simulated data."
    missing = notes(found)
    parts: list[Any] = [
        f"<p>{escape(facts)}</p>" + "".join(f"<p><b>{escape(m)}</b></p>" for m in missing)
    ]
    parts += [one for name, one in drawn.items() if name.startswith("map")]
    if any(
        one["part"].endswith(" gap") and one["note"] for one in records if one["part"] != "no gap"
    ):
        parts += ["<h2>Gaps, means with 95 % intervals</h2>" + _gap_table(records)]
    parts += [one for name, one in drawn.items() if name.startswith("gaps")]
    if "retrieval" in drawn:
        parts += [drawn["retrieval"]]
    if "neighbours" in drawn:
        parts += [drawn["neighbours"]]
    if "probe" in drawn:
        rows = [r for r in records if r["part"] == "probe" and r["note"]]
        head = ("probe of", "accuracy", "mean", "95 % interval", "over")
        cells = [
            (VIEWS[r["modality"]], r["measure"], _number(r["value"]), _ends(r), r["note"])
            for r in rows
        ]
        parts += [drawn["probe"], _table(head, cells)]
    parts += [
        f"<h2>Methods</h2><p>{escape(words)}</p><p>Every number is in numbers.csv; the figures are in figures/ as SVG.</p>"
    ]
    return parts


def notes(found: Features) -> list[str]:
    """Return what the set cannot show, one sentence each."""
    words = []
    if len(found.domains) < 2:
        words.append("One domain: there is no gap between domains, and no probe meets another one.")
    if len(found.modalities) < 2:
        words.append(
            f"One modality ({VIEWS[found.modalities[0]]}): there is no gap between modalities and no retrieval."
        )
    if not found.labelled:
        words.append("No classes: probes and mAP are left out.")
    sizes = {name: len(found.members(name)) for name in found.domains}
    if few := [name for name, size in sizes.items() if size < LEAST]:
        words.append(f"Fewer than {LEAST} pairs, so no gap and no probe: {', '.join(few)}.")
    if len(sizes) - len(few) > MOST_DOMAINS:
        words.append(f"Gaps are of the {MOST_DOMAINS} largest domains.")
    if len(found.embeddings) < found.drawn_of:
        words.append(f"{len(found.embeddings):,} of {found.drawn_of:,} pairs were drawn at random.")
    return words


def _gap_table(records: Sequence[Record]) -> str:
    means = [r for r in records if r["part"] in ("modality gap", "domain gap") and r["note"]]
    floors = {(r["measure"], r["modality"]): r["value"] for r in records if r["part"] == "no gap"}
    cells = []
    for one in means:
        level = floors.get((one["measure"], one["modality"]))
        what = (
            "between photos and touches"
            if not one["modality"]
            else f"between domains, {VIEWS[one['modality']]}"
        )
        cells.append(
            (
                one["measure"],
                what,
                _number(one["value"]),
                _ends(one),
                "–" if level is None else _number(level),
            )
        )
    return _table(("measure", "gap", "mean", "95 % interval", "two halves of one domain"), cells)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = ["".join(f"<th>{escape(cell)}</th>" for cell in head)]
    lines += ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
    return (
        '<div class="table"><table>'
        + "".join(f"<tr>{line}</tr>" for line in lines)
        + "</table></div>"
    )


def _number(value: float) -> str:
    return "–" if value is None or math.isnan(value) else f"{value:.3f}"


def _ends(one: Record) -> str:
    return "–" if one["low"] is None else f"{_number(one['low'])} to {_number(one['high'])}"


def methods(found: Features, seed: int) -> str:
    """Return one paragraph for a paper: what was measured, how, and with which versions."""
    data = found.embeddings
    sizes = ", ".join(f"{name} {len(found.members(name))}" for name in found.domains)
    made = f"Features of {data.header.encoder} ({data.width} values) of {len(data)} pairs ({sizes}) were scaled to unit length."
    drawn = (
        f" They are a random part of {found.drawn_of} pairs." if len(data) < found.drawn_of else ""
    )
    return (
        f"{made}{drawn} Gaps between modalities and between domains were measured by {', '.join(GAPS)} (Proxy-A after Ben-David et al. 2007, MMD "
        "after Gretton et al. 2012, Fréchet after Dowson and Landau 1982); intervals are a jackknife over 8 blocks of objects, and the same "
        "measure between random halves of one domain shows what no gap gives. Finite samples raise every measure but a cross-validated one. "
        "Retrieval ranks the partners of one domain by cosine. Other intervals are 95 % percentiles of a bootstrap over objects, or over "
        f"domains for probes. A probe is multinomial logistic regression (C = 1) on centred unit rows of one domain; its accuracy at home is "
        f"{FOLDS}-fold over objects. A profile matches mean and deviation of each channel to the source's, from {PROFILE} unlabelled pictures of "
        f"the target that are not tested. UMAP after McInnes et al. 2018 (exact neighbours, 15, seed {seed}). omnivat {__version__}, "
        f"torch {torch.__version__}, numpy {np.__version__}, Python {platform.python_version()}."
    )
