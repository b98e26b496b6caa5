"""Import embeddings from another program, or pictures of recordings.

python -m omnivat import FILE --encoder NAME --out set.safetensors [--domain NAME] [--column
material=class] python -m omnivat import LEROBOT --out PAIRS [--frames 5] [--pick even|contact]
[--labels episodes.csv] python -m omnivat import videos.csv --out PAIRS
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.cli.arguments import choice, listed, passed, progress_bar, shared, whole
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import require_writable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnivat.data.pairs import Skipped


def add(parser: argparse.ArgumentParser) -> None:
    text = (
        ".npz, .parquet, .h5 or .csv (docs/encoders.md), a LeRobot data set, or a table of videos"
        " (docs/data.md)"
    )
    parser.add_argument("file", type=Path, help=text)
    shared(parser, out="the .safetensors file to write; of recordings, a new folder of pairs")
    text = "name of the vectors' encoder; recordings need none"
    parser.add_argument("--encoder", default="", metavar="NAME", help=text)
    add_foreign(parser)
    parser.add_argument("--preprocessing", default="", help="preprocessing of the images")
    parser.add_argument("--origin", default="", help="one line on the file's origin")
    parser.add_argument(
        "--frames",
        type=whole(1),
        default=5,
        metavar="N",
        help="pairs of each recording; default: 5",
    )
    choice(
        parser,
        "--pick",
        ("even", "contact"),
        "moments: evenly spaced, or where the touch differs most",
    )
    parser.add_argument("--vis", default="", metavar="CAMERA", help="LeRobot: camera of the photos")
    text = "LeRobot: tactile camera; can be given several times"
    parser.add_argument("--tac", action="append", default=[], metavar="CAMERA", help=text)
    text = "LeRobot: columns episode, material, perhaps domain, object, split"
    parser.add_argument("--labels", type=Path, metavar="CSV", help=text)
    choice(parser, "--dtype", ("float32", "float16"), "of the written file")


def add_foreign(parser: argparse.ArgumentParser) -> None:
    """Declare what a file of another program may lack."""
    parser.add_argument("--domain", default="", help="of all pairs, if the file has none")
    parser.add_argument("--classes", default="", help="names of numbered materials, with commas")
    text = "another name of a column, such as material=label; can be given several times"
    parser.add_argument("--column", action="append", default=[], metavar="OURS=THEIRS", help=text)
    parser.add_argument("--simulated", action="store_true", help="the pairs are simulated")


def run(options: argparse.Namespace) -> None:
    """Read, check, write; print a summary."""
    from omnivat.data.foreign import import_embeddings
    from omnivat.data.recordings import is_recording
    from omnivat.data.store import manifest_place, require_own, save_embeddings

    if is_recording(options.file):
        _recordings(options)
        return
    if not options.encoder:
        raise SettingsError(
            f"'{options.file}' is no recording, so --encoder has to name the encoder of its"
            " vectors."
        )
    require_writable(options.out, ".safetensors")
    require_own(manifest_place(options.out, "csv"))
    about = passed(options, "encoder", "preprocessing", "origin")
    imported = import_embeddings(options.file, **about, **foreign(options))
    save_embeddings(options.out, imported, dtype=options.dtype)
    header = imported.header
    print(
        f"{len(imported)} pairs of width {imported.width} by {header.encoder}: domains"
        f" {', '.join(header.domains)}; materials {', '.join(header.classes)}; written to"
        f" {options.out}"
    )


def _recordings(options: argparse.Namespace) -> None:
    """Write pictures of recordings as a folder of pairs."""
    from omnivat.data.recordings import clips_of, write_pairs

    clips = clips_of(options.file, **passed(options, "vis", "tac", "domain", "labels"))
    with progress_bar("import") as show:
        count, skipped = write_pairs(
            clips, options.out, **passed(options, "frames", "pick"), on_step=show
        )
    _tell(skipped)
    print(
        f"{count} pairs of {len(clips) - len(skipped)} recordings; next: python -m omnivat try"
        f" {options.out}"
    )


def _tell(skipped: "Sequence[Skipped]") -> None:
    for one in skipped[:3]:
        print(f"left out: {one.what}: {one.why}")
    if len(skipped) > 3:
        print(f"left out: {len(skipped) - 3} more")


def foreign(options: argparse.Namespace) -> dict[str, Any]:
    """Return what `add_foreign` declares, for a reader; raises SettingsError for a column in
    another form.
    """
    for text in options.column:
        if not all(text.partition("=")):
            raise SettingsError(f"--column got '{text}'; write it as OURS=THEIRS.")
    columns = dict(text.split("=", 1) for text in options.column)
    return passed(options, "domain", "simulated") | {
        "classes": listed(options.classes),
        "columns": columns,
    }
