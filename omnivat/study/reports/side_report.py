"""Further tables: late fusion, confidence, margins of each target, the LANG guard."""

import math
from collections.abc import Sequence

from omnivat.head.fusion import FUSIONS
from omnivat.study.reports.evidence_report import method_table, percent
from omnivat.study.reports.intervals import spread
from omnivat.study.reports.reading import Record

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
    "Every fusion mixes the same two predictions. The weight of a learned fusion, and which fusion"
    " a source uses, come from its held-out objects, plain and under imitated sensors; “feature”"
    " classifies the sum of the two features."
)
CONFIDENCE_NOTE = (
    "On unseen targets, both images, mean fusion; rows whose records hold the probabilities. ECE in"
    " percent, NLL in nats, AURC: area under the risk-coverage curve, × 100. Temperatures are"
    " fitted to held-out objects of the source, plain and under imitated sensors; they change no"
    " prediction."
)
MARGIN_NOTE = (
    "Mean cosine of pairs of one class minus that of pairs of different classes, all pairs counted,"
    " mean over sources and seeds. [V;T]: both features side by side; V, T: one image, the other"
    " absent."
)
GUARD_NOTE = (
    "The text is that of the pair's own class, as in training. A gap of 5 points or more means that"
    " training taught the head to read the label from the text."
)


def _mean(records: Sequence[Record], part: str, name: str, metric: str) -> float:
    """Return the mean of a score over targets, then runs; NaN without values."""
    runs = []
    for record in records:
        values = [
            v
            for t in record["targets"].values()
            if (v := t[part].get(name, {}).get(metric)) is not None
        ]
        runs += [sum(values) / len(values)] if values else []
    return spread(runs).mean


def fusion_table(records: Sequence[Record]) -> str:
    """Return ACC / Macro-F1 of every late fusion, for methods with two predictions."""

    def cells(own: list[Record]) -> list[str]:
        own = [r for r in own if any(t.get("fusions") for t in r["targets"].values())]
        if not own:
            return []
        found = []
        for kind in FUSIONS:
            values = [_mean(own, "fusions", kind, metric) for metric in ("accuracy", "macro_f1")]
            found.append("–" if math.isnan(values[0]) else " / ".join(map(percent, values)))
        chosen = [r.get("chosen", {}).get("fusion", "") for r in own]
        counts = {kind: chosen.count(kind) for kind in dict.fromkeys(chosen) if kind}
        return [*found, ", ".join(f"{k} {n}" for k, n in counts.items())]

    return method_table(records, [*FUSIONS, "chosen on the source (runs)"], cells)


def confidence_table(records: Sequence[Record]) -> str:
    """Return ECE, NLL and AURC before and after the temperature, of calibrated methods."""

    def cells(own: list[Record]) -> list[str]:
        told = all("ece" in t["scores"]["fused"] for r in own for t in r["targets"].values())
        if not (told and all(r.get("settings", {}).get("calibrate") for r in own)):
            return []
        found = []
        for metric in CONFIDENCE:
            pair = [_mean(own, "scores", "fused", key) for key in (f"{metric}_raw", metric)]
            scale, digits = (1, 2) if metric == "nll" else (100, 1)
            found.append(" → ".join(f"{scale * v:.{digits}f}" for v in pair))
        return [*found, f"{spread([r['temperature']['fused'] for r in own]).mean:.2f}"]

    return method_table(records, [*CONFIDENCE.values(), "mean temperature"], cells)


def margin_table(records: Sequence[Record]) -> str:
    """Return the cosine margin of every method on every target."""
    found = [r for r in records if any("margins" in t for t in r.get("targets", {}).values())]
    targets = list(dict.fromkeys(t for record in found for t in record["targets"]))

    def cell(own: list[Record], target: str) -> str:
        values = [r["targets"][target]["margins"] for r in own if target in r["targets"]]
        return " / ".join(_margin([v.get(kind) for v in values]) for kind in ("pair", "vis", "tac"))

    return method_table(found, targets, lambda own: [cell(own, target) for target in targets])


def _margin(values: Sequence[float | None]) -> str:
    given = [value for value in values if value is not None]
    return f"{100 * sum(given) / len(given):.1f}" if given else "–"


def guard_table(records: Sequence[Record]) -> str:
    """Return ACC on the source's test with the text of a pair's class, and without."""

    def cells(own: list[Record]) -> list[str]:
        guards = [r["lang_guard"] for r in own if "lang_guard" in r]
        means = [spread([guard[kind] for guard in guards]).mean for kind in ("with", "without")]
        return [*map(percent, means), f"{100 * (means[0] - means[1]):+.1f}"] if guards else []

    return method_table(records, ["with text", "without", "gap"], cells)
