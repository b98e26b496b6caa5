"""Compare several embeddings of the same pairs: which encoder survives a new sensor.

python -m omnivat compare A.safetensors B.safetensors [--json FILE --markdown FILE --figure FILE]
python -m omnivat compare mine=A.npz theirs=B.npz --only tac --target force
"""

import argparse
from pathlib import Path

from omnivat.cli.arguments import count, declare, figure, flag, one_of, passed, path, progress_bar
from omnivat.cli.imports import add_foreign, foreign
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import require_writable
from omnivat.measure.rungs import DRAWS


def add(parser: argparse.ArgumentParser) -> None:
    words = (
        "two or more embeddings of the same pairs, as files of `omnivat embed` or as `omnivat"
        " import` reads them; NAME=FILE names a row; the first is what others are compared with"
    )
    parser.add_argument("sets", nargs="+", metavar="SET", help=words)
    add_foreign(parser)
    figure(parser, "the table")
    declare(
        parser,
        "seed",
        "target",
        json=path("also write every number as JSON", "FILE"),
        markdown=path("also write the table as Markdown", "FILE"),
        only=one_of(("all", "vis", "tac"), "photos or touches alone, or all that every set has"),
        draws=count(f"draws of known pictures; default: {DRAWS}", default=DRAWS, metavar="N"),
        no_cost=flag("do not time the encoders"),
    )


def run(options: argparse.Namespace) -> None:
    """Read, measure, print, write."""
    from omnivat import figures
    from omnivat.kit.files import write_json, write_text
    from omnivat.study.comparison import compare, table
    from omnivat.study.comparison.table import chart
    from omnivat.study.shift import read_features

    for file in filter(None, (options.json, options.markdown)):
        require_writable(file)
    named: dict[str, Path] = {}
    for given in options.sets:
        name, equals, file = given.partition("=")
        if not equals or Path(given).exists():
            name, file = Path(given).stem, given
        if name in named:
            raise SettingsError(f"Two sets are called '{name}'; name one with NAME=FILE.")
        named[name] = Path(file)
    how = foreign(options) | {
        "seed": options.seed,
        "numbers": tuple(filter(None, [options.target])),
    }
    sets = {name: read_features(file, **how) for name, file in named.items()}
    with progress_bar("compare") as show:
        found = compare(
            sets,
            view="" if options.only == "all" else options.only,
            cost=not options.no_cost,
            **passed(options, "target", "draws", "seed"),
            on_step=show,
        )
    words = table(found)
    if options.json:
        write_json(options.json, found)
    if options.markdown:
        write_text(options.markdown, words)
    if options.figure:
        title = (
            f"Predicting {options.target}" if options.target else "The same pairs, several encoders"
        )
        across, percent = ("R²", False) if options.target else ("accuracy", True)
        drawn = figures.dots(chart(found), title=title, across=across, percent=percent)
        figures.write(options.figure, drawn)
    print(words, end="")
