"""Three readings of every method, and OmniVaT against the best other row."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from omnivat.study.reports import bootstrap
from omnivat.study.reports.bootstrap import (
    METRICS,
    Resampled,
    Row,
    complete_rows,
    draws_for,
    resampled,
)
from omnivat.study.reports.intervals import Interval
from omnivat.study.reports.markdown import (
    interval_text,
    markdown,
    method_table,
    percent,
    score_cells,
)
from omnivat.study.reports.reading import METRICS as NAMES
from omnivat.study.reports.reading import Record, by_run, by_seed, methods

OURS = ("omnivat", "fused")
READINGS = {"vis": "photo only", "tac": "touch only", "fused": "both"}


def readings_parts(records: Sequence[Record]) -> list[str]:
    """Return the headline, the table of readings and the differences; empty without predictions."""
    parts = ["## Photo only, touch only, both: ACC / Macro-F1", readings_table(records)]
    parts.append(
        "Mean over unseen targets, then sources; ± standard deviation (n − 1) over seeds. Photo"
        " only and touch only: the other image is absent. Both: the mean of two predictions, or the"
        " one prediction of a method that joins features."
    )
    found = compared(records)
    if found is None:
        return parts
    return [
        "## OmniVaT against the best other row",
        "Both images:",
        *map(found.headline, METRICS),
        (
            "Intervals: hierarchical bootstrap over sources, seeds and test objects (the objects of"
            " a test set are drawn once for all sources), simultaneous over all rows below by the"
            " max-t method; 2,000 draws."
        ),
        *parts,
        "## OmniVaT, both images, minus every other row",
        found.table(),
        *ablated_part(records),
    ]


def ablated_part(records: Sequence[Record]) -> list[str]:
    """Return OmniVaT minus itself with one part switched off; empty without such runs."""
    found = compared(records, only_ablated=True)
    if found is None:
        return []
    return ["## OmniVaT minus itself with one part switched off", "Both images.", found.table()]


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
        return f"{self.labels[row[0]]}, {READINGS[row[1]]}"

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
    rows = complete_rows(records, ("fused",) if only_ablated else tuple(READINGS))
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
    """Return one line for each method: ACC / Macro-F1 of each reading."""
    sources = list(dict.fromkeys(record["source"] for record in records))

    def cells(runs: list[Record]) -> list[str]:
        name = runs[0]["method"]
        found = [
            score_cells(*(by_seed(by_run(runs, name, m, reading), sources) for m in METRICS))
            for reading in READINGS
        ]
        return [*found, str(len({record["seed"] for record in runs}))]

    return method_table(records, [*READINGS.values(), "seeds"], cells)
