"""Run the paper's ablations and write their tables and plots.

python -m omnivat ablate --embeddings FILE --out DIR [--only components,order] [--seeds 0,1,2]
"""

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from omnivat.cli.arguments import declare, listed, numbers, split_settings, text
from omnivat.cli.protocol import RUNS, add_running, work
from omnivat.kit.files import require_writable

if TYPE_CHECKING:
    from omnivat.study.ablations import Ablation
    from omnivat.study.protocol.run import Run


def add(parser: argparse.ArgumentParser) -> None:
    add_running(parser)
    declare(
        parser,
        "only",
        sources=text("instead of the paper's", "A,B"),
        set="a base setting of all rows, such as width=64",
    )


def run(options: argparse.Namespace) -> None:
    """Run what is missing, then write tables and plots."""
    from omnivat.head.settings import HeadSettings
    from omnivat.study.ablations import chosen
    from omnivat.study.protocol import records
    from omnivat.study.reports.ablation_report import write_ablations
    from omnivat.training import TrainSettings

    require_writable(options.out / RUNS)
    tables, sources = chosen(listed(options.only)), listed(options.sources)
    if sources:
        tables = {name: replace(table, sources=sources) for name, table in tables.items()}
    if not options.tables_only:
        head, training = split_settings(options.set, HeadSettings, TrainSettings)
        runs = planned_rows(tables, numbers(options.seeds), head, training)
        work(runs, options, lang=training.get("lang", True))
    print(write_ablations(records.read(options.out / RUNS), tables, options.out))


def planned_rows(
    tables: "dict[str, Ablation]",
    seeds: tuple[int, ...],
    head: dict[str, Any],
    training: dict[str, Any],
) -> "list[Run]":
    """Return the runs of all tables; a row in several tables runs once."""
    from omnivat.study.ablations import method_name
    from omnivat.study.protocol.methods import HEAD, Method
    from omnivat.study.protocol.run import Run

    runs: dict[tuple[str, str, int], Run] = {}
    for seed in seeds:
        for table in tables.values():
            for source in table.sources:
                for row, one in table.rows.items():
                    ours = one.base == HEAD
                    method = Method(
                        name=method_name(row),
                        label=one.label,
                        base=one.base,
                        head={**head, **one.head} if ours else {},
                        train={**training, **one.train} if ours else {},
                        modalities=one.modalities,
                    )
                    runs[row, source, seed] = Run(method=method, source=source, seed=seed)
    return list(runs.values())
