"""Simulate the eight visual-tactile domains.

python -m omnivat simulate --out DIR [--pairs-per-class 40] [--seed 0] [--examples DIR]
"""

import argparse
from pathlib import Path

from omnivat.cli.bar import progress_bar


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--out", type=Path, required=True, help="folder for the pairs")
    parser.add_argument("--domains", help="only these, with commas")
    parser.add_argument("--pairs-per-class", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--examples", type=Path, help="copy a few test pairs here, as JPEG")
    parser.add_argument("--examples-per-class", type=int, default=2, metavar="N")
    parser.add_argument("--workers", type=int, help="processes; all cores if left out")


def run(options: argparse.Namespace) -> None:
    """Render and press every surface; files that are there already are kept."""
    from omnivat.data.pairs import summary_table
    from omnivat.simulate.build import simulate
    from omnivat.simulate.examples import write_examples

    domains = [name.strip() for name in options.domains.split(",")] if options.domains else None
    with progress_bar("simulate") as show:
        made = simulate(
            options.out,
            domains=domains,
            pairs_per_class=options.pairs_per_class,
            seed=options.seed,
            workers=options.workers,
            on_step=show,
        )
    print(summary_table(made))
    if options.examples:
        files = write_examples(made, options.examples, each=options.examples_per_class)
        size = sum(file.stat().st_size for file in files) / 1e6
        print(f"{len(files) // 2} example pairs in '{options.examples}', {size:.1f} MB")
