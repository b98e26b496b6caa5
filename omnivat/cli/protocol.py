"""Run the paper's experiment: one source, unseen targets, several methods and seeds.

python -m omnivat protocol --embeddings FILE --out DIR --methods a,b,c --seeds 0,1,2
"""

import argparse
from typing import TYPE_CHECKING

from omnivat.cli.arguments import (
    declare,
    flag,
    head_and_training,
    list_of,
    passed,
    path,
    progress_bar,
)
from omnivat.kit.errors import DataError
from omnivat.kit.files import require_writable

if TYPE_CHECKING:
    from omnivat.study.protocol.run import Run

RUNS = "runs.jsonl"


def add(parser: argparse.ArgumentParser) -> None:
    add_running(parser)
    images = (
        "the folder or table of pairs that was embedded, for methods that learn inside CLIP; noted"
        " by `omnivat embed` on this machine"
    )
    declare(
        parser,
        methods=list_of("methods by name; default: all fast ones", "a,b,c"),
        sources=list_of("domains to train on; default: all in the set", "A,B"),
        set="a setting of the head or of its training, such as width=64 or noise=4",
        images=path(images, "PAIRS"),
    )


def add_running(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments shared by `protocol` and `ablate`."""
    declare(
        parser,
        "embeddings",
        "lang",
        "seeds",
        "jobs",
        "device",
        out="folder for records and tables",
        tables_only=flag("rebuild tables, run nothing"),
    )


def run(options: argparse.Namespace) -> None:
    """Run what is missing, then write the tables."""
    from omnivat.cli.thumbnails import start_of
    from omnivat.data.store import load_embeddings
    from omnivat.encoders.hub import images_key, remember
    from omnivat.study.protocol import records
    from omnivat.study.protocol.engine import planned
    from omnivat.study.protocol.methods import DEFAULT_METHODS, methods_named
    from omnivat.study.protocol.settings import available
    from omnivat.study.reports.protocol_report import write_report

    require_writable(options.out / RUNS)
    if not options.tables_only:
        set_of_pairs = load_embeddings(options.embeddings)
        if options.images and not options.images.exists():
            raise DataError(f"There is no folder or file at '{options.images}'. Check --images.")
        if options.images:
            remember(
                images_key(set_of_pairs.header), start_of(options.images, set_of_pairs.rows["vis"])
            )
        head, training = head_and_training(options.set)
        methods = methods_named(options.methods or DEFAULT_METHODS, head, training)
        sources = options.sources or available(set_of_pairs)
        if not sources:
            raise DataError(
                f"'{options.embeddings}' has no domain with pairs of two classes or more to learn"
                " from."
            )
        runs = planned(methods, sources, options.seeds)
        work(runs, options, lang=training.get("lang", True))
    print(write_report(records.read(options.out / RUNS), options.out))


def work(runs: "list[Run]", options: argparse.Namespace, *, lang: bool = True) -> None:
    """Run with a progress bar; without LANG, no method has text."""
    from omnivat.encoders.lang.bank import DEFAULT_BANK
    from omnivat.study.protocol.engine import run_all

    bank = (options.lang or DEFAULT_BANK) if lang else None
    how = passed(options, "embeddings", "jobs")
    with progress_bar(f"{len(runs)} runs") as show:
        done = run_all(runs, options.out / RUNS, bank=bank, **how, on_step=show)
    print(f"{done} runs done, {len(runs) - done} were there already")
