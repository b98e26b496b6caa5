"""Run the paper's ablations and write their tables and plots.

python -m omnivat ablate --embeddings FILE --out DIR [--only components,order] [--seeds 0,1,2]
"""

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from omnivat.cli.arguments import declare, head_and_training, list_of
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
        sources=list_of("instead of the paper's", "A,B"),
        set="a base setting of all rows, such as width=64",
    )


def run(options: argparse.Namespace) -> None:
    """Run what is missing, then write tables and plots."""
    from omnivat.study.ablations import chosen
    from omnivat.study.protocol import records
    from omnivat.study.reports.ablation_report import write_ablations

    require_writable(options.out / RUNS)
    tables = chosen(options.only)
    if options.sources:
        tables = {n: replace(table, sources=options.sources) for n, table in tables.items()}
    if not options.tables_only:
        head, training = head_and_training(options.set)
        runs = planned_rows(tables, options.seeds, head, training)
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
                for row, record in table.rows.items():
                    ours = record.base == HEAD
                    method = Method(
                        name=method_name(row),
                        label=record.label,
                        base=record.base,
                        head={**head, **record.head} if ours else {},
                        train={**training, **record.train} if ours else {},
                        modalities=record.modalities,
                    )
                    runs[row, source, seed] = Run(method=method, source=source, seed=seed)
    return list(runs.values())
