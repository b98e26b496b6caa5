"""Source-side evidence as a table: held-out objects, plain and under imitated sensors."""

from collections.abc import Sequence
from pathlib import Path

from omnivat.files import write_text
from omnivat.reports.intervals import Spread, spread
from omnivat.reports.reading import Record
from omnivat.reports.text_table import markdown, spread_text

REPORT = "evidence.md"
COLUMNS = (
    ("plain", "accuracy"),
    ("plain", "macro_f1"),
    ("shifted", "accuracy"),
    ("shifted", "macro_f1"),
)


def write_evidence(records: Sequence[Record], folder: Path) -> str:
    """Write `evidence.md` into the folder and return its text."""
    text = evidence_report(records)
    write_text(folder / REPORT, text)
    return text


def evidence_report(records: Sequence[Record]) -> str:
    """Return the table of runs with a fold, sorted by the mean of both Macro-F1s."""
    found = [r for r in records if r["fold"] is not None and "targets" in r]
    if not found:
        return "No evidence yet.\n"
    rows = []
    for name in dict.fromkeys(record["method"] for record in found):
        own = [record for record in found if record["method"] == name]
        spreads = [_spread(own, kind, metric) for kind, metric in COLUMNS]
        rows.append(
            (spreads[1].mean + spreads[3].mean, [own[0]["label"], *map(spread_text, spreads)])
        )
    rows.sort(key=lambda row: -row[0])
    header = ["method", "held-out ACC", "held-out Macro-F1", "shifted ACC", "shifted Macro-F1"]
    runs = len({(r["source"], r["seed"], r["fold"]) for r in found})
    return (
        "# Source-side evidence\n\nHeld-out objects of the source, as they are and under imitated "
        f"sensors; no target was used. Mean ± standard deviation over {runs} runs "
        "(sources × seeds × folds).\n\n" + markdown(header, [cells for _, cells in rows]) + "\n"
    )


def _spread(records: Sequence[Record], kind: str, metric: str) -> Spread:
    """Return the spread over runs of a score on held-out pairs, plain or averaged over shifts."""
    values = []
    for record in records:
        scores = [
            target["scores"]["fused"][metric]
            for name, target in record["targets"].items()
            if (name == "held out") == (kind == "plain")
        ]
        values.append(sum(scores) / len(scores))
    return spread(values)
