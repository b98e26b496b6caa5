"""Further tables: confidence, margins of each target, the LANG guard."""

from collections.abc import Sequence

from omnivat.study.reports.intervals import spread
from omnivat.study.reports.markdown import margin_text, method_table, percent
from omnivat.study.reports.reading import Record, by_run, targets_of

# measure -> its column, factor and digits
CONFIDENCE = {"ece": ("ECE", 100, 1), "nll": ("NLL", 1, 2), "aurc": ("AURC", 100, 1)}


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


def confidence_table(records: Sequence[Record]) -> str:
    """Return ECE, NLL and AURC: the mean of both images over targets, then runs."""

    def cells(runs: list[Record]) -> list[str]:
        if not all("nll" in t["scores"]["fused"] for r in runs for t in r["targets"].values()):
            return []
        means = {name: spread(list(by_run(runs, name).values())).mean for name in CONFIDENCE}
        return [
            f"{factor * means[name]:.{digits}f}" for name, (_, factor, digits) in CONFIDENCE.items()
        ]

    return method_table(records, [column for column, *_ in CONFIDENCE.values()], cells)


def margin_table(records: Sequence[Record]) -> str:
    """Return the cosine margin of every method on every target."""
    with_margins = [
        r for r in records if any("margins" in t for t in r.get("targets", {}).values())
    ]
    targets = targets_of(with_margins)

    def cell(runs: list[Record], target: str) -> str:
        margins = [r["targets"][target]["margins"] for r in runs if target in r["targets"]]
        return " / ".join(
            margin_text([margin.get(kind) for margin in margins], 100, 1)
            for kind in ("pair", "vis", "tac")
        )

    return method_table(with_margins, targets, lambda runs: [cell(runs, t) for t in targets])


def guard_table(records: Sequence[Record]) -> str:
    """Return ACC on the source's test with the text of a pair's class, and without."""

    def cells(runs: list[Record]) -> list[str]:
        guards = [r["lang_guard"] for r in runs if "lang_guard" in r]
        means = [spread([guard[kind] for guard in guards]).mean for kind in ("with", "without")]
        return [*map(percent, means), f"{100 * (means[0] - means[1]):+.1f}"] if guards else []

    return method_table(records, ["with text", "without", "gap"], cells)
