"""Further tables: confidence, margins of each target, the LANG guard."""

from collections.abc import Sequence

from omnivat.study.reports.intervals import spread
from omnivat.study.reports.markdown import method_table, percent
from omnivat.study.reports.reading import Record

CONFIDENCE = {"ece": "ECE", "nll": "NLL", "aurc": "AURC"}


def side_parts(records: Sequence[Record]) -> list[str]:
    """Return the tables for which these records have figures."""
    parts = []
    for title, table, note in (
        ("Confidence", confidence_table, CONFIDENCE_NOTE),
        ("Cosine margin × 100 of each target: [V;T] / V / T", margin_table, MARGIN_NOTE),
        ("LANG guard: ACC on the source's test with and without text", guard_table, GUARD_NOTE),
    ):
        text = table(records)
        if text:
            parts += [f"## {title}", text, note]
    return parts


CONFIDENCE_NOTE = (
    "On unseen targets, both images; rows whose records hold the probabilities. ECE in percent, NLL"
    " in nats, AURC: area under the risk-coverage curve, × 100. No temperature is fitted."
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


def _mean(records: Sequence[Record], metric: str) -> float:
    """Return the mean of a score of both images over targets, then runs."""
    runs = []
    for record in records:
        values = [target["scores"]["fused"][metric] for target in record["targets"].values()]
        runs.append(sum(values) / len(values))
    return spread(runs).mean


def confidence_table(records: Sequence[Record]) -> str:
    """Return ECE, NLL and AURC."""

    def cells(runs: list[Record]) -> list[str]:
        if not all("nll" in t["scores"]["fused"] for r in runs for t in r["targets"].values()):
            return []
        scales = {"ece": (100, 1), "nll": (1, 2), "aurc": (100, 1)}
        return [f"{scales[m][0] * _mean(runs, m):.{scales[m][1]}f}" for m in CONFIDENCE]

    return method_table(records, list(CONFIDENCE.values()), cells)


def margin_table(records: Sequence[Record]) -> str:
    """Return the cosine margin of every method on every target."""
    found = [r for r in records if any("margins" in t for t in r.get("targets", {}).values())]
    targets = list(dict.fromkeys(t for record in found for t in record["targets"]))

    def cell(runs: list[Record], target: str) -> str:
        values = [r["targets"][target]["margins"] for r in runs if target in r["targets"]]
        return " / ".join(_margin([v.get(kind) for v in values]) for kind in ("pair", "vis", "tac"))

    return method_table(found, targets, lambda runs: [cell(runs, target) for target in targets])


def _margin(values: Sequence[float | None]) -> str:
    given = [value for value in values if value is not None]
    return f"{100 * sum(given) / len(given):.1f}" if given else "–"


def guard_table(records: Sequence[Record]) -> str:
    """Return ACC on the source's test with the text of a pair's class, and without."""

    def cells(runs: list[Record]) -> list[str]:
        guards = [r["lang_guard"] for r in runs if "lang_guard" in r]
        means = [spread([guard[kind] for guard in guards]).mean for kind in ("with", "without")]
        return [*map(percent, means), f"{100 * (means[0] - means[1]):+.1f}"] if guards else []

    return method_table(records, ["with text", "without", "gap"], cells)
