"""The paper's margin and cost tables, with printed and our figures."""

from collections.abc import Mapping, Sequence
from typing import Any

from omnivat.data.domains import paper_name
from omnivat.study.reports.markdown import margin_text, method_table
from omnivat.study.reports.paper import MARK, mark, paper
from omnivat.study.reports.reading import Record, latest, targets_of

SOURCE = "TAG"  # the source of the paper's margins


def margins_report(records: Sequence[Record]) -> str:
    """Return the cosine margins of the concatenated features, from TAG, with the printed figures.

    The paper's figures over two targets ("[A; B]") are shown; ours are for single targets.
    """
    found = [r for r in latest(records) if paper_name(r["source"]) == SOURCE and "targets" in r]
    if not found:
        return f"# Cosine margins from {SOURCE}\n\nNo run has {SOURCE} as its source.\n"
    printed = paper()["margins"]
    targets = targets_of(found)
    joint = [name for name in next(iter(printed.values())) if name.startswith("[")]
    below = []
    for label, cells in printed.items():
        values = [cells.get(name) for name in (*map(paper_name, targets), *joint)]
        below.append(
            [
                f"printed: {label}{mark(found[0]['data'])}",
                *("–" if v is None else f"{v:.3f}" for v in values),
            ]
        )

    def cell(runs: list[Record], target: str) -> str:
        margins = (run["targets"].get(target, {}).get("margins", {}) for run in runs)
        return margin_text([margin.get("pair") for margin in margins], 1, 3)

    table = method_table(
        found,
        [*targets, *joint],
        lambda runs: [cell(runs, target) for target in targets] + ["–"] * len(joint),
        below=below,
    )
    return f"# Cosine margins from {SOURCE}\n\nMean over seeds, both images.\n\n{table}\n"


def cost_report(records: Sequence[Record], measured: Mapping[str, Any]) -> str:
    """Return parameters, training time and pairs per second, with the printed figures.

    measured  "encoder, s a pair", "memory, MB" and "machine", as measured by `omnivat reproduce`
    """
    columns = ["parameters, millions", "training, s", "inference, FPS", "GPU memory, MB"]

    def cells(runs: list[Record]) -> list[str]:
        size = max(record["parameters"] for record in runs) / 1e6
        seconds = sum(record["seconds"] for record in runs) / len(runs)
        rate, memory = 1 / measured["encoder, s a pair"], measured.get("memory, MB")
        return [f"{size:.2f}", f"{seconds:.1f}", f"{rate:.1f}", f"{memory:.0f}" if memory else "–"]

    below = []
    for label, printed in paper()["cost"].items():
        values = [None if name == "training, s" else printed.get(name) for name in columns]
        texts = ("–" if value is None else f"{value:g}" for value in values)
        below.append([f"printed: {label} {MARK} (their machine)", *texts])
    table = method_table(latest(records), columns, cells, below=below)
    note = (
        f"On {measured['machine']}. Training is a whole fit on cached embeddings, with the choices"
        " on held-out objects; the paper prints seconds for an epoch with the encoder, a different"
        " quantity. FPS is pairs per second with the encoder, which takes nearly all of the time."
    )
    return f"# Cost\n\n{table}\n\n{note}\n"
