"""Run the paper's experiment: one source, unseen targets, several methods and seeds.

python -m omnivat protocol --embeddings FILE --out DIR --methods a,b,c --seeds 0,1,2
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from omnivat.cli.bar import progress_bar
from omnivat.errors import DataError, SettingsError
from omnivat.heads import default_embeddings

if TYPE_CHECKING:
    from omnivat.protocol.run import Run

RUNS = "runs.jsonl"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_running(parser)
    parser.add_argument(
        "--methods", default="", metavar="a,b,c", help="all that are quick if left out"
    )
    parser.add_argument(
        "--sources", default="", metavar="A,B", help="all that the set has if left out"
    )
    parser.add_argument(
        "--folds",
        type=int,
        default=0,
        help="source-side evidence instead: this many folds of held-out objects, no target",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="key=value",
        help="a setting of the head or of its training, such as width=64 or selection=source-val",
    )


def add_running(parser: argparse.ArgumentParser) -> None:
    """Declare what `protocol` and `ablate` share."""
    parser.add_argument("--embeddings", type=Path, default=default_embeddings())
    parser.add_argument("--lang", type=Path, help="LANG bank; the project's own if left out")
    parser.add_argument("--out", type=Path, required=True, help="folder for records and tables")
    parser.add_argument("--seeds", default="0,1,2", metavar="0,1,2")
    parser.add_argument("--jobs", type=int, default=1, help="processes side by side")
    parser.add_argument("--engine", default="local", choices=("local", "ray"))
    parser.add_argument("--tables-only", action="store_true", help="rebuild tables, run nothing")


def run(options: argparse.Namespace) -> None:
    """Do what is not done yet, then write the tables anew."""
    from omnivat.cli.train import split_settings
    from omnivat.data.store import load_embeddings
    from omnivat.model.settings import HeadSettings
    from omnivat.protocol import records
    from omnivat.protocol.engine import planned
    from omnivat.protocol.methods import DEFAULT_METHODS, methods_named
    from omnivat.protocol.settings import available
    from omnivat.reports.evidence_report import write_evidence
    from omnivat.reports.protocol_report import write_report
    from omnivat.train import TrainSettings

    if not options.tables_only:
        set_of_pairs = load_embeddings(options.embeddings)
        head, training = split_settings(options.set, HeadSettings, TrainSettings)
        methods = methods_named(listed(options.methods) or DEFAULT_METHODS, head, training)
        sources = listed(options.sources) or available(set_of_pairs)
        if not sources:
            raise DataError(
                f"'{options.embeddings}' has no domain with pairs of two classes or more to learn "
                "from."
            )
        folds = tuple(range(options.folds)) or (None,)
        work(planned(methods, sources, numbers(options.seeds), folds), options)
    found = records.read(options.out / RUNS)
    print(write_evidence(found, options.out) if options.folds else write_report(found, options.out))


def work(runs: "list[Run]", options: argparse.Namespace) -> None:
    """Do the runs with a bar."""
    from omnivat.lang.bank import DEFAULT_BANK
    from omnivat.protocol.engine import run_all

    if options.jobs < 1:
        raise SettingsError(f"--jobs is {options.jobs}; choose 1 or more.")
    with progress_bar(f"{len(runs)} runs") as show:
        done = run_all(
            runs,
            options.out / RUNS,
            embeddings=options.embeddings,
            bank=options.lang or DEFAULT_BANK,
            jobs=options.jobs,
            engine=options.engine,
            on_step=show,
        )
    print(f"{done} runs done, {len(runs) - done} were there already")


def listed(text: str) -> tuple[str, ...]:
    """Return the parts of "a,b,c" without blanks around them."""
    return tuple(part.strip() for part in text.split(",") if part.strip())


def numbers(text: str, *, name: str = "--seeds") -> tuple[int, ...]:
    """Return the whole numbers of "0,1,2"; raises SettingsError for anything else."""
    try:
        found = tuple(int(part) for part in listed(text))
    except ValueError as error:
        raise SettingsError(f"{name} is '{text}'; give whole numbers such as 0,1,2.") from error
    if not found:
        raise SettingsError(f"{name} is empty; give whole numbers such as 0,1,2.")
    return found
