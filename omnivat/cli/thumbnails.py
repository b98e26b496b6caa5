"""Make the page's sheet of thumbnails for a set of embeddings.

python -m omnivat thumbnails PAIRS --embeddings FILE
"""

import argparse
from collections.abc import Iterable, Sequence
from pathlib import Path

from omnivat.cli.arguments import count, declare, path, progress_bar
from omnivat.kit.errors import DataError
from omnivat.kit.files import require_writable


def add(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("pairs", type=Path, help="the embedded folder or CSV of pairs")
    declare(
        parser,
        "embeddings",
        out=path("a .webp; default: next to the embeddings"),
        tile=count("side of one thumbnail in pixels", 8, 512, default=64),
    )


def run(options: argparse.Namespace) -> None:
    """Read every image once, write one sheet."""
    if not options.pairs.exists():
        raise DataError(f"There is no folder or file at '{options.pairs}'. Check the path.")
    from omnivat.data.store import load_embeddings
    from omnivat.maps.thumbnails import sheet_of, write_thumbnails

    embeddings = load_embeddings(options.embeddings)
    out = options.out or sheet_of(options.embeddings)
    require_writable(out, ".webp")
    root = start_of(options.pairs, [*embeddings.rows["vis"]])
    with progress_bar("thumbnails") as show:
        missing = write_thumbnails(embeddings, root, out, tile=options.tile, on_step=show)
    print(f"{2 * len(embeddings)} thumbnails written to {out}, {missing} images missing")


def start_of(pairs: Path, names: Sequence[str], known: Sequence[Path] = ()) -> Path:
    """Return the base folder of the names in an embeddings file.

    known  the photos of its pairs, if they were read

    `embed` shortens names by the common path of all images. For a table, and for a data set with
    deeper folders, that is not the given folder.
    """
    folder = pairs if pairs.is_dir() else pairs.parent
    if not names or (folder / names[0]).is_file():
        return folder
    table = pairs / "pairs.csv" if pairs.is_dir() else pairs
    files: Iterable[Path] = known
    if not known and table.is_file():
        from omnivat.data.readers.table import read

        files = [pair.vis.absolute() for pair in read(table).pairs]
    elif not known:
        files = folder.rglob(Path(names[0]).name)
    wanted = Path(names[0]).parts
    depth = len(wanted)
    starts = {file.parents[depth - 1] for file in files if file.parts[-depth:] == wanted}
    return starts.pop() if len(starts) == 1 else folder  # with two candidates, neither is certain
