"""Three readings of every method, and OmniVaT against the best other row."""

from collections.abc import Mapping, Sequence

from omnivat.model.fusion import FUSIONS
from omnivat.reports.bootstrap import (
    METRICS,
    Resampled,
    Row,
    complete_rows,
    draws_for,
    percentile,
    resampled,
    simultaneous,
)
from omnivat.reports.evidence_report import interval_text, markdown, percent, spread_text
from omnivat.reports.intervals import Interval, spread
from omnivat.reports.reading import METRICS as NAMES
from omnivat.reports.reading import Record, by_run, by_seed, completed, methods

OURS = ("omnivat", "fused")
CHOSEN = ("omnivat", "chosen")
READINGS = {"vis": "photo only", "tac": "touch only", "fused": "both, mean fusion", "chosen": "both, chosen fusion"}


def readings_parts(records: Sequence[Record]) -> list[str]:
    """Return the headline, the table of readings and the differences; empty without predictions."""
    parts = ["## Photo only, touch only, both: ACC / Macro-F1", readings_table(records)]
    parts.append(
        "Mean over unseen targets, then sources; ± standard deviation (n − 1) over seeds. Photo "
        "only and touch only: the other image is absent. Both, mean fusion: the mean of two "
        "predictions, or the one prediction of a method that joins features (“–” under chosen fusion). "
        "Chosen fusion: the one with the lowest log loss on held-out objects of the source."
    )
    found = compared(records)
    if found is None:
        return parts
    ours, others = found
    intervals = {metric: simultaneous(ours[metric], others[metric]) for metric in METRICS}
    labels = methods(records)
    return [
        "## OmniVaT against the best other row",
        "Both images, mean fusion:",
        *[headline(metric, ours, others, intervals, labels) for metric in METRICS],
        *_chosen_headline(records, others, labels),
        "Intervals: hierarchical bootstrap over sources, seeds and test objects (the objects of a "
        "test set are drawn once for all sources), simultaneous over all rows below by the max-t "
        "method; 2,000 draws.",
        *parts,
        "## OmniVaT, both images by mean fusion, minus every other row",
        differences_table(ours, others, intervals, labels),
        *ablated_part(records),
    ]


def _chosen_headline(
    records: Sequence[Record], others: Mapping[str, Mapping[Row, Resampled]], labels: Mapping[str, str]
) -> list[str]:
    """Return the headline for the chosen fusion, if runs chose another than the mean."""
    chosen = {r.get("chosen", {}).get("fusion", "mean") for r in completed(records, OURS[0])}
    if chosen == {"mean"} or CHOSEN not in complete_rows(records, (CHOSEN[1],)):
        return []
    ours = resampled(records, CHOSEN, draws_for([r for r in records if "targets" in r]))
    intervals = {metric: simultaneous(ours[metric], others[metric]) for metric in METRICS}
    lines = [headline(metric, ours, others, intervals, labels) for metric in METRICS]
    return ["The same with the fusion chosen on the source:", *lines]


def ablated_part(records: Sequence[Record]) -> list[str]:
    """Return OmniVaT minus itself with one part switched off; empty without such runs.

    Only sources where OmniVaT kept the settings of these rows count: it may choose, they may not.
    """
    own = [r for r in completed(records, OURS[0]) if r.get("settings", {}).get("candidates")]
    left = {r["source"] for r in own if r["chosen"].get("settings") != "as set"}
    found = compared([r for r in records if r["source"] not in left], only_ablated=True)
    if found is None:
        return []
    ours, others = found
    intervals = {metric: simultaneous(ours[metric], others[metric]) for metric in METRICS}
    table = differences_table(ours, others, intervals, methods(records))
    note = "Both images, mean fusion."
    if left:
        note += (
            f" Without {', '.join(sorted(left))}: there OmniVaT chose other settings on held-out "
            "objects, a choice that the rows below do not have."
        )
    return ["## OmniVaT minus itself with one part switched off", note, table]


def compared(
    records: Sequence[Record], *, only_ablated: bool = False
) -> tuple[dict[str, Resampled], dict[str, dict[Row, Resampled]]] | None:
    """Return OmniVaT's resampled metrics, and those of every row of another method.

    only_ablated  compare with OmniVaT's own ablations instead, both images only
    """
    late = (f"fusion:{kind}" for kind in FUSIONS if kind != "mean")
    names = ("fused",) if only_ablated else (*READINGS, *late)
    rows = complete_rows(records, names)
    if OURS not in rows:
        return None
    drawn = draws_for([r for r in records if "targets" in r])
    ours = resampled(records, OURS, drawn)
    others: dict[str, dict[Row, Resampled]] = {metric: {} for metric in METRICS}
    ablated = {record["method"] for record in records if record.get("ablated")}
    for row in rows:
        if row[0] != OURS[0] and (row[0] in ablated) == only_ablated:
            for metric, values in resampled(records, row, drawn).items():
                others[metric][row] = values
    return (ours, others) if others[METRICS[0]] else None


def row_label(row: Row, labels: Mapping[str, str]) -> str:
    """Return a row's name: the method's label and its reading."""
    method, reading = row
    kind = READINGS.get(reading) or f"both, {reading.partition(':')[2]} fusion"
    return f"{labels[method]}, {kind}"


def headline(
    metric: str,
    ours: Mapping[str, Resampled],
    others: Mapping[str, Mapping[Row, Resampled]],
    intervals: Mapping[str, Mapping[Row, Interval]],
    labels: Mapping[str, str],
) -> str:
    """Return one sentence for a metric: ours, the best other row, and the interval."""
    best = max(others[metric], key=lambda row: others[metric][row].value)
    found = intervals[metric][best]
    verdict = "zero is outside" if found.low > 0 or found.high < 0 else "zero is inside"
    return (
        f"**{NAMES[metric]}**: OmniVaT {percent(ours[metric].value)}; best of "
        f"{len(others[metric])} other rows: {row_label(best, labels)}, "
        f"{percent(others[metric][best].value)}. Difference {interval_text(found)}: {verdict}."
    )


def differences_table(
    ours: Mapping[str, Resampled],
    others: Mapping[str, Mapping[Row, Resampled]],
    intervals: Mapping[str, Mapping[Row, Interval]],
    labels: Mapping[str, str],
) -> str:
    """Return every difference with its simultaneous and its single interval."""
    first = METRICS[0]
    order = sorted(others[first], key=lambda row: -others[first][row].value)
    rows = []
    for row in order:
        cells = []
        for metric in METRICS:
            cells += [
                interval_text(intervals[metric][row]),
                interval_text(percentile(ours[metric], others[metric][row])),
            ]
        rows.append([row_label(row, labels), *cells])
    header = [f"{NAMES[m]}, {kind}" for m in METRICS for kind in ("simultaneous", "alone")]
    return markdown(["OmniVaT minus", *header], rows)


def readings_table(records: Sequence[Record]) -> str:
    """Return one line for each method: ACC / Macro-F1 of each reading, and the fusion of "both"."""
    sources = list(dict.fromkeys(record["source"] for record in records))
    rows = []
    for name, label in methods(records).items():
        own = completed(records, name)
        if not own:
            continue
        cells = []
        for reading in READINGS:
            values = [by_seed(by_run(records, name, m, reading), sources) for m in METRICS]
            text = " / ".join(spread_text(spread(v)) for v in values)
            cells.append(text.replace("– / –", "–"))
        seeds = {record["seed"] for record in own}
        fusions = sorted({record.get("chosen", {}).get("fusion", "") for record in own} - {""})
        rows.append([label, *cells, ", ".join(fusions), str(len(seeds))])
    return markdown(["method", *READINGS.values(), "late fusion", "seeds"], rows)
