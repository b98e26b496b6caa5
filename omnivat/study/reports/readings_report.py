"""Three readings of every method, and OmniVaT against the best other row."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from omnivat.study.reports.bootstrap import (
    Resampled,
    Row,
    complete_rows,
    draws_for,
    percentile,
    resampled,
    simultaneous,
)
from omnivat.study.reports.markdown import (
    interval_text,
    markdown,
    method_table,
    percent,
    score_cell,
)
from omnivat.study.reports.reading import METRICS, SCORES, Record, methods, sources_of

OURS = ("omnivat", "fused")
READINGS = {"vis": "photo only", "tac": "touch only", "fused": "both"}


def readings_parts(records: Sequence[Record]) -> list[str]:
    """Return the headline, the table of readings and the differences; empty without predictions."""
    parts = [
        "## Photo only, touch only, both: ACC / Macro-F1",
        readings_table(records),
        "Mean over unseen targets, then sources; ± standard deviation (n − 1) over seeds. Photo"
        " only and touch only: the other image is absent. Both: the mean of two predictions, or the"
        " one prediction of a method that joins features.",
    ]
    rows = compared(records)
    if rows is None:
        return parts
    return [
        "## OmniVaT against the best other row",
        "Both images:",
        *map(rows.headline, SCORES),
        (
            "Intervals: hierarchical bootstrap over sources, seeds and test objects (the objects of"
            " a test set are drawn once for all sources), simultaneous over all rows below by the"
            " max-t method; 2,000 draws."
        ),
        *parts,
        "## OmniVaT, both images, minus every other row",
        rows.table(),
        *ablated_part(records),
    ]


def ablated_part(records: Sequence[Record]) -> list[str]:
    """Return OmniVaT minus itself with one part switched off; empty without such runs."""
    rows = compared(records, only_ablated=True)
    if rows is None:
        return []
    return ["## OmniVaT minus itself with one part switched off", "Both images.", rows.table()]


@dataclass(frozen=True, slots=True)
class Compared:
    """OmniVaT and every other row, resampled, by metric; and the labels of methods."""

    ours: Mapping[str, Resampled]
    others: Mapping[Row, Mapping[str, Resampled]]
    labels: Mapping[str, str]

    def of(self, metric: str) -> dict[Row, Resampled]:
        """Return the other rows by one metric, best first."""
        rows = {row: values[metric] for row, values in self.others.items()}
        return dict(sorted(rows.items(), key=lambda item: -item[1].value))

    def label(self, row: Row) -> str:
        """Return a row's name: the method's label and its reading."""
        return f"{self.labels[row[0]]}, {READINGS[row[1]]}"

    def headline(self, metric: str) -> str:
        """Return one sentence for a metric: ours, the best other row, and the interval."""
        ours, others = self.ours[metric], self.of(metric)
        best, value = next(iter(others.items()))
        lead = simultaneous(ours, others)[best]
        verdict = "zero is outside" if lead.low > 0 or lead.high < 0 else "zero is inside"
        return (
            f"**{METRICS[metric]}**: OmniVaT {percent(ours.value)}; best of {len(others)} other"
            f" rows: {self.label(best)}, {percent(value.value)}. Difference {interval_text(lead)}:"
            f" {verdict}."
        )

    def table(self) -> str:
        """Return every difference with its simultaneous and its single interval."""
        leads = {metric: simultaneous(self.ours[metric], self.of(metric)) for metric in SCORES}
        rows = []
        for row in self.of(SCORES[0]):
            cells = [self.label(row)]
            for metric, ours in self.ours.items():
                alone = percentile(ours, self.others[row][metric])
                cells += [interval_text(leads[metric][row]), interval_text(alone)]
            rows.append(cells)
        header = [f"{METRICS[m]}, {kind}" for m in SCORES for kind in ("simultaneous", "alone")]
        return markdown(["OmniVaT minus", *header], rows)


def compared(records: Sequence[Record], *, only_ablated: bool = False) -> Compared | None:
    """Return OmniVaT and every row of another method; None without predictions of both.

    only_ablated  compare with OmniVaT's own ablations instead, both images only
    """
    rows = complete_rows(records, ("fused",) if only_ablated else tuple(READINGS))
    ablated = {record["method"] for record in records if record.get("ablated")}
    others = [r for r in rows if r[0] != OURS[0] and (r[0] in ablated) == only_ablated]
    if OURS not in rows or not others:
        return None
    drawn = draws_for([r for r in records if "targets" in r])
    ours, *theirs = (resampled(records, row, drawn) for row in (OURS, *others))
    return Compared(ours, dict(zip(others, theirs, strict=True)), methods(records))


def readings_table(records: Sequence[Record]) -> str:
    """Return one line for each method: ACC / Macro-F1 of each reading."""
    sources = sources_of(records)

    def cells(runs: list[Record]) -> list[str]:
        scores = [score_cell(runs, sources, reading) for reading in READINGS]
        return [*scores, str(len({record["seed"] for record in runs}))]

    return method_table(records, [*READINGS.values(), "seeds"], cells)
