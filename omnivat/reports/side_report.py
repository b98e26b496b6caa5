"""Further tables: late fusion, confidence, margins of each target, the LANG guard."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from omnivat.model.fusion import FUSIONS
from omnivat.reports.evidence_report import markdown, percent
from omnivat.reports.intervals import spread
from omnivat.reports.reading import Record, completed, methods

CONFIDENCE = {"ece": "ECE", "nll": "NLL", "aurc": "AURC"}


def side_parts(records: Sequence[Record]) -> list[str]:
    """Return the tables for which these records have figures."""
    parts = []
    for title, table, note in (
        ("Late fusion: ACC / Macro-F1 of both images", fusion_table, FUSION_NOTE),
        ("Confidence, before → after temperature", confidence_table, CONFIDENCE_NOTE),
        ("Cosine margin × 100 of each target: [V;T] / V / T", margin_table, MARGIN_NOTE),
        ("LANG guard: ACC on the source's test with and without text", guard_table, GUARD_NOTE),
    ):
        text = table(records)
        if text:
            parts += [f"## {title}", text, note]
    return parts


FUSION_NOTE = (
    "Every fusion mixes the same two predictions. "
    "The weight of a learned fusion, and which fusion a source uses, come from its held-out objects, "
    "plain and under imitated sensors; “feature” classifies the sum of the two features."
)
CONFIDENCE_NOTE = (
    "On unseen targets, both images, mean fusion; rows whose records hold the probabilities. ECE in percent, NLL in nats, AURC: area under the risk-coverage "
    "curve, × 100. Temperatures are fitted to held-out objects of the source, plain and under "
    "imitated sensors; they change no prediction."
)
MARGIN_NOTE = (
    "Mean cosine of pairs of one class minus that of pairs of different classes, all pairs counted, "
    "mean over sources and seeds. [V;T]: both features side by side; V, T: one image, the other absent."
)
GUARD_NOTE = (
    "The text is that of the pair's own class, as in training. A gap of 5 points or more means that "
    "training taught the head to read the label from the text."
)


def _mean(records: Sequence[Record], value: Callable[[Any], float | None]) -> float:
    """Return the mean over targets, then runs; NaN without values."""
    runs = []
    for record in records:
        values = [v for t in record["targets"].values() if (v := value(t)) is not None]
        runs += [sum(values) / len(values)] if values else []
    return spread(runs).mean


def fusion_table(records: Sequence[Record]) -> str:
    """Return ACC / Macro-F1 of every late fusion, for methods with two predictions."""
    rows = []
    for name, label in methods(records).items():
        own = [r for r in completed(records, name) if any(t.get("fusions") for t in _targets(r))]
        if not own:
            continue
        cells = []
        for kind in FUSIONS:
            values = [
                _mean(own, lambda t, k=kind, m=metric: t["fusions"].get(k, {}).get(m))  # type: ignore[misc]
                for metric in ("accuracy", "macro_f1")
            ]
            cells.append("–" if math.isnan(values[0]) else " / ".join(map(percent, values)))
        chosen = [r.get("chosen", {}).get("fusion", "") for r in own]
        counts = {kind: chosen.count(kind) for kind in dict.fromkeys(chosen) if kind}
        rows.append([label, *cells, ", ".join(f"{k} {n}" for k, n in counts.items())])
    return markdown(["method", *FUSIONS, "chosen on the source (runs)"], rows) if rows else ""


def _targets(record: Record) -> list[Any]:
    return list(record["targets"].values())


def confidence_table(records: Sequence[Record]) -> str:
    """Return ECE, NLL and AURC before and after the temperature, of calibrated methods."""
    rows = []
    for name, label in methods(records).items():
        own = completed(records, name)
        told = all("ece" in t["scores"]["fused"] for r in own for t in _targets(r))
        if not (own and told and all(r.get("settings", {}).get("calibrate") for r in own)):
            continue
        cells = []
        for metric in CONFIDENCE:
            pair = [
                _mean(own, lambda t, k=key: t["scores"].get("fused", {}).get(k))  # type: ignore[misc]
                for key in (f"{metric}_raw", metric)
            ]
            scale = 1 if metric == "nll" else 100
            digits = 2 if metric == "nll" else 1
            cells.append(" → ".join(f"{scale * v:.{digits}f}" for v in pair))
        temperature = spread([r["temperature"]["fused"] for r in own]).mean
        rows.append([label, *cells, f"{temperature:.2f}"])
    return markdown(["method", *CONFIDENCE.values(), "mean temperature"], rows) if rows else ""


def margin_table(records: Sequence[Record]) -> str:
    """Return the cosine margin of every method on every target."""
    found = [r for r in records if any("margins" in t for t in r.get("targets", {}).values())]
    targets = list(dict.fromkeys(t for record in found for t in record["targets"]))
    rows = []
    for name, label in methods(found).items():
        own = completed(found, name)
        cells = []
        for target in targets:
            values = [r["targets"][target]["margins"] for r in own if target in r["targets"]]
            cells.append(" / ".join(_margin([v.get(kind) for v in values]) for kind in ("pair", "vis", "tac")))
        rows.append([label, *cells])
    return markdown(["method", *targets], rows) if rows else ""


def _margin(values: Sequence[float | None]) -> str:
    given = [value for value in values if value is not None]
    return f"{100 * sum(given) / len(given):.1f}" if given else "–"


def guard_table(records: Sequence[Record]) -> str:
    """Return ACC on the source's test with the text of a pair's class, and without."""
    rows = []
    for name, label in methods(records).items():
        own = [r["lang_guard"] for r in completed(records, name) if "lang_guard" in r]
        if own:
            means = [spread([guard[kind] for guard in own]).mean for kind in ("with", "without")]
            rows.append([label, *map(percent, means), f"{100 * (means[0] - means[1]):+.1f}"])
    return markdown(["method", "with text", "without", "gap"], rows) if rows else ""
