"""The comparison as Markdown: main table, intervals, every target, and the paper's figures."""

from collections.abc import Sequence
from pathlib import Path

from omnivat.kit.files import write_text
from omnivat.study.reports.intervals import spread
from omnivat.study.reports.markdown import count_text, markdown, method_table, percent, score_cell
from omnivat.study.reports.paper import mark, paper_rows, target_rows
from omnivat.study.reports.reading import (
    METRICS,
    SCORES,
    Record,
    by_run,
    changed_settings,
    completed,
    latest,
    methods,
    origin,
    sources_of,
    targets_of,
)
from omnivat.study.reports.readings_report import readings_parts
from omnivat.study.reports.side_report import side_parts

REPORT = "report.md"


def write_report(records: Sequence[Record], folder: Path) -> str:
    """Write `report.md` into the folder and return its text."""
    text = protocol_report(records)
    write_text(folder / REPORT, text)
    return text


def protocol_report(records: Sequence[Record]) -> str:
    """Return the whole report of a protocol's records."""
    runs = latest(records)
    if not runs:
        return "No runs yet.\n"
    parts = [
        "# Single-domain generalization: comparison",
        origin(runs),
        *readings_parts(runs),
        "## Each source, both images by mean fusion: ACC / Macro-F1, mean over unseen targets",
        main_table(runs),
        "Mean ± standard deviation (n − 1) over seeds; Macro-F1 over classes present in a target.",
        *side_parts(runs),
        "## Macro-F1 with predicted classes counted too (union), source test, size, time",
        side_table(runs),
        "## Every target",
        *[part for name, label in methods(runs).items() for part in _targets(runs, name, label)],
        *_printed_targets(runs),
        _notes(runs),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def main_table(records: Sequence[Record]) -> str:
    """Return the paper's main table from these records, with its printed rows below."""
    sources = sources_of(records)

    def cells(runs: list[Record]) -> list[str]:
        return [score_cell(runs, some) for some in (*([source] for source in sources), sources)]

    header = [*(f"{s} → X" for s in sources), "average"]
    return method_table(records, header, cells, below=paper_rows(sources, records[0]["data"]))


def side_table(records: Sequence[Record]) -> str:
    """Return further figures of each method, averaged over all runs."""

    def cells(runs: list[Record]) -> list[str]:
        union = spread(list(by_run(runs, "macro_f1_union").values())).mean
        test = [
            r["source_test"]["scores"]["fused"]["accuracy"] for r in runs if r.get("source_test")
        ]
        seconds = sorted(r["seconds"] for r in runs)[len(runs) // 2]
        size = count_text([r["parameters"] for r in runs])
        return [percent(union), percent(spread(test).mean), size, f"{seconds:.1f}"]

    header = [METRICS["macro_f1_union"], "source-test ACC", "parameters", "fit, s (median)"]
    return method_table(records, header, cells)


def _targets(records: Sequence[Record], name: str, label: str) -> list[str]:
    """Return the matrix source × target of ACC / Macro-F1, mean over seeds."""
    runs = completed(records, name)
    targets = targets_of(runs)

    def cell(source: str, target: str) -> str:
        of_source = [r["targets"] for r in runs if r["source"] == source]
        scores = [run[target]["scores"]["fused"] for run in of_source if target in run]
        means = (percent(spread([s[metric] for s in scores]).mean) for metric in SCORES)
        return " / ".join(means) if scores else ""

    rows = [[source, *(cell(source, target) for target in targets)] for source in sources_of(runs)]
    return [f"### {label}", markdown(["source", *targets], rows)] if rows else []


def _printed_targets(records: Sequence[Record]) -> list[str]:
    """Return the paper's tables of single targets for the sources in these records."""
    data, targets = records[0]["data"], targets_of(records)
    rows = [
        [source, *row]
        for source in sources_of(records)
        for row in target_rows(source, targets, data)
    ]
    if not rows:
        return []
    note = f"Printed by the paper, ViT-B/16{mark(data, ablations=True)}."
    return ["### Printed, every target", note, markdown(["source", "method", *targets], rows)]


def _notes(records: Sequence[Record]) -> str:
    """Return the notes on methods and targets as Markdown; "" without any."""
    kinds: list[list[str]] = [[], [], [], [], []]  # one list for each kind of note
    for r in records:
        label, source = r["label"], r["source"]
        if r["note"]:
            kinds[0].append(f"- {label}: {r['note']}.")
        if r.get("settings"):
            kinds[1].append(f"- {label}: settings {changed_settings(r) or 'as the defaults'}.")
        if chosen := r.get("chosen", {}).get("settings"):
            kinds[2].append(f"- {label}, {source}: settings chosen on the source: {chosen}.")
        if "skipped" in r:
            kinds[3].append(f"- {label} did not run: {r['skipped']}")
        if r["missing_targets"]:
            kinds[4].append(
                f"- From {source} these targets have no pairs of the learned classes:"
                f" {', '.join(r['missing_targets'])}."
            )
    lines = dict.fromkeys(line for notes in kinds for line in notes)
    return "\n".join(["## Notes", "", *lines]) if lines else ""
