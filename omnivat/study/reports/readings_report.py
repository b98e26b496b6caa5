"""Three readings of every method, and OmniVaT against the best other row."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from omnivat.head.fusion import FUSIONS
from omnivat.study.reports import bootstrap
from omnivat.study.reports.bootstrap import (
    METRICS,
    Resampled,
    Row,
    complete_rows,
    draws_for,
    resampled,
)
from omnivat.study.reports.evidence_report import (
    interval_text,
    markdown,
    method_table,
    percent,
    score_cells,
)
from omnivat.study.reports.intervals import Interval
from omnivat.study.reports.reading import METRICS as NAMES
from omnivat.study.reports.reading import Record, by_run, by_seed, completed, methods

OURS = ("omnivat", "fused")
CHOSEN = ("omnivat", "chosen")
READINGS = {
    "vis": "photo only",
    "tac": "touch only",
    "fused": "both, mean fusion",
    "chosen": "both, chosen fusion",
}


def readings_parts(records: Sequence[Record]) -> list[str]:
    """Return the headline, the table of readings and the differences; empty without predictions."""
    parts = ["## Photo only, touch only, both: ACC / Macro-F1", readings_table(records)]
    parts.append(
        "Mean over unseen targets, then sources; ± standard deviation (n − 1) over seeds. Photo"
        " only and touch only: the other image is absent. Both, mean fusion: the mean of two"
        " predictions, or the one prediction of a method that joins features (“–” under chosen"
        " fusion). Chosen fusion: the one with the lowest log loss on held-out objects of the"
        " source."
    )
    found = compared(records)
    if found is None:
        return parts
    return [
        "## OmniVaT against the best other row",
        "Both images, mean fusion:",
        *map(found.headline, METRICS),
        *_chosen_headline(records, found),
        (
            "Intervals: hierarchical bootstrap over sources, seeds and test objects (the objects of"
            " a test set are drawn once for all sources), simultaneous over all rows below by the"
            " max-t method; 2,000 draws."
        ),
        *parts,
        "## OmniVaT, both images by mean fusion, minus every other row",
        found.table(),
        *ablated_part(records),
    ]


def _chosen_headline(records: Sequence[Record], found: "Compared") -> list[str]:
    """Return the headline for the chosen fusion, if runs chose another than the mean."""
    chosen = {r.get("chosen", {}).get("fusion", "mean") for r in completed(records, OURS[0])}
    if chosen == {"mean"} or CHOSEN not in complete_rows(records, (CHOSEN[1],)):
        return []
    ours = resampled(records, CHOSEN, draws_for([r for r in records if "targets" in r]))
    lines = map(replace(found, ours=ours).headline, METRICS)
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
    note = "Both images, mean fusion."
    if left:
        note += (
            f" Without {', '.join(sorted(left))}: there OmniVaT chose other settings on held-out "
            "objects, a choice that the rows below do not have."
        )
    return ["## OmniVaT minus itself with one part switched off", note, found.table()]


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """OmniVaT's resampled metrics, those of every other row, and the labels of methods."""

    ours: Mapping[str, Resampled]
    others: Mapping[str, Mapping[Row, Resampled]]
    labels: Mapping[str, str]

    def intervals(self, metric: str) -> dict[Row, Interval]:
        """Return the simultaneous intervals of OmniVaT minus every other row."""
        return bootstrap.simultaneous(self.ours[metric], self.others[metric])

    def label(self, row: Row) -> str:
        """Return a row's name: the method's label and its reading."""
        kind = READINGS.get(row[1]) or f"both, {row[1].partition(':')[2]} fusion"
        return f"{self.labels[row[0]]}, {kind}"

    def headline(self, metric: str) -> str:
        """Return one sentence for a metric: ours, the best other row, and the interval."""
        others = self.others[metric]
        best = max(others, key=lambda row: others[row].value)
        found = self.intervals(metric)[best]
        verdict = "zero is outside" if found.low > 0 or found.high < 0 else "zero is inside"
        return (
            f"**{NAMES[metric]}**: OmniVaT {percent(self.ours[metric].value)}; best of"
            f" {len(others)} other rows: {self.label(best)}, {percent(others[best].value)}."
            f" Difference {interval_text(found)}: {verdict}."
        )

    def table(self) -> str:
        """Return every difference with its simultaneous and its single interval."""
        intervals, rows = {metric: self.intervals(metric) for metric in METRICS}, []
        for row in sorted(
            self.others[METRICS[0]], key=lambda row: -self.others[METRICS[0]][row].value
        ):
            cells = [self.label(row)]
            for metric in METRICS:
                alone = bootstrap.percentile(self.ours[metric], self.others[metric][row])
                cells += [interval_text(intervals[metric][row]), interval_text(alone)]
            rows.append(cells)
        header = [f"{NAMES[m]}, {kind}" for m in METRICS for kind in ("simultaneous", "alone")]
        return markdown(["OmniVaT minus", *header], rows)


def compared(records: Sequence[Record], *, only_ablated: bool = False) -> Compared | None:
    """Return OmniVaT and every row of another method; None without predictions of both.

    only_ablated  compare with OmniVaT's own ablations instead, both images only
    """
    late = (f"fusion:{kind}" for kind in FUSIONS if kind != "mean")
    rows = complete_rows(records, ("fused",) if only_ablated else (*READINGS, *late))
    if OURS not in rows:
        return None
    drawn = draws_for([r for r in records if "targets" in r])
    others: dict[str, dict[Row, Resampled]] = {metric: {} for metric in METRICS}
    ablated = {record["method"] for record in records if record.get("ablated")}
    for row in rows:
        if row[0] != OURS[0] and (row[0] in ablated) == only_ablated:
            for metric, values in resampled(records, row, drawn).items():
                others[metric][row] = values
    if not others[METRICS[0]]:
        return None
    return Compared(ours=resampled(records, OURS, drawn), others=others, labels=methods(records))


def readings_table(records: Sequence[Record]) -> str:
    """Return one line for each method: ACC / Macro-F1 of each reading, and the fusion of "both"."""
    sources = list(dict.fromkeys(record["source"] for record in records))

    def cells(own: list[Record]) -> list[str]:
        name, found = own[0]["method"], []
        for reading in READINGS:
            text = score_cells(*(by_seed(by_run(own, name, m, reading), sources) for m in METRICS))
            found.append(text.replace("– / –", "–"))
        fusions = sorted({record.get("chosen", {}).get("fusion", "") for record in own} - {""})
        return [*found, ", ".join(fusions), str(len({record["seed"] for record in own}))]

    return method_table(records, [*READINGS.values(), "late fusion", "seeds"], cells)
