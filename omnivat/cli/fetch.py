"""Bring a real data set of others as a folder of pairs; without a name, list the sets and their
terms.

python -m omnivat fetch [NAME] [--out DIR] [--from URL|PATH]
"""

import argparse
from pathlib import Path

from omnivat.cli.arguments import declare, path, progress_bar, text
from omnivat.kit.errors import SettingsError


def add(parser: argparse.ArgumentParser) -> None:
    words = "a set; left out: list the sets"
    parser.add_argument("name", nargs="?", default="", metavar="NAME", help=words)
    source = text("another copy of the repository", "URL|PATH") | {"dest": "source"}
    declare(parser, out=path("folder to write; default: NAME", "DIR"), **{"from": source})


def run(options: argparse.Namespace) -> None:
    """List the sets, or bring one."""
    if options.name:
        bring(options.name, options.out or Path(options.name), options.source)
    elif options.out or options.source:
        raise SettingsError("Name the set to fetch; `python -m omnivat fetch` lists them.")
    else:
        print(listing())


def bring(name: str, out: Path, source: str = "") -> Path:
    """Fetch a set into `out` with a progress bar, print its terms, and return `out`."""
    from omnivat.data.fetching import TERMS, fetch

    with progress_bar(f"fetch {name}") as show:
        fetch(name, out, source=source, on_step=show)
    print((out / TERMS).read_text(encoding="utf-8"), end="")
    print(f"The pairs are in {out}: python -m omnivat try {out}")
    return out


def listing() -> str:
    """Return the sets with sensor, number of pairs, size and terms, as text."""
    from omnivat.data.fetching import fetched_sets

    blocks = []
    for entry in fetched_sets().values():
        size = (
            f"{entry.megabytes / 1000:.3g} GB"
            if entry.megabytes >= 1000
            else f"{entry.megabytes} MB"
        )
        pairs = f"{entry.pairs:,} pairs, " if entry.pairs else ""
        blocks.append(
            f"{entry.name}  {entry.sensor}; {pairs}{size}\n    {entry.what}\n"
            f"    terms: {entry.said}\n    {entry.source} at {entry.commit[:7]}"
        )
    note = (
        "Nothing of them is part of this project. `fetch NAME` brings one from its authors, with"
        " its terms."
    )
    return "\n".join([*blocks, "", note])
