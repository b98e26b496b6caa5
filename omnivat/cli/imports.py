"""Import embeddings, recordings or pictures of another program.

python -m omnivat import FILE --encoder NAME --out set.safetensors [--domain NAME] [--column
material=class] python -m omnivat import LEROBOT|videos.csv|RECORDING|hf:OWNER/NAME --out PAIRS
[--frames 5] [--pick even|contact] [--look FILE.png] python -m omnivat import FOLDER --vis rgb --tac
gelsight --out PAIRS
"""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.cli.arguments import (
    assigned,
    count,
    declare,
    flag,
    list_of,
    one_of,
    passed,
    path,
    progress_bar,
    several,
    text,
)
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import require_writable

if TYPE_CHECKING:
    from omnivat.data.pairs import PairSet

ALIGN = "photo and touch films of different length: one moment of both, or one share of each"
TOUCHES = "touches: the same; several cameras or columns can be given, one a domain"


def add(parser: argparse.ArgumentParser) -> None:
    words = (
        "vectors (docs/encoders.md): .npz, .parquet, .h5, .safetensors or .csv, with --encoder;"
        " else (docs/data.md) a LeRobot data set, a table of videos, .hapt, .touch, the same files"
        " with pictures, a folder of pictures, or hf:OWNER/NAME of the model hub"
    )
    parser.add_argument("file", type=Path, help=words)
    add_foreign(parser)
    moments = "moments: evenly spaced, or where the touch differs most"
    declare(
        parser,
        "vis",
        "look",
        out="the .safetensors file to write; of recordings and pictures, a new folder of pairs",
        encoder=text("name of the vectors' encoder; pictures need none", "NAME"),
        preprocessing=text("preprocessing of the images"),
        origin=text("one line on the file's origin"),
        align=one_of(("time", "share"), ALIGN),
        frames=count("pairs of each recording; default: 5", default=5, metavar="N"),
        pick=one_of(("even", "contact"), moments),
        tac=several(TOUCHES, "NAME"),
        numbers=list_of("columns of numbers to keep, such as force,slip (for --target)", "a,b"),
        labels=path(
            "columns episode (LeRobot) or file, material, perhaps domain, object, split", "CSV"
        ),
        dtype=one_of(("float32", "float16"), "of the written file"),
    )


def add_foreign(parser: argparse.ArgumentParser) -> None:
    """Declare what a file of another program may lack."""
    words = "another name of a column, such as material=label; can be given several times"
    declare(
        parser,
        domain=text("of all pairs, if the file has none"),
        classes=list_of("names of numbered materials, with commas"),
        column=several(words, "OURS=THEIRS", type=assigned),
        simulated=flag("the pairs are simulated"),
    )


def run(options: argparse.Namespace) -> None:
    """Read, check, write; print a summary."""
    from omnivat.data.fetching.hub import PREFIX, hub_folder

    if str(options.file).startswith(PREFIX):
        options.file = hub_folder(str(options.file))
    if options.encoder:
        _vectors(options)
    else:
        _pictures(options)


def _vectors(options: argparse.Namespace) -> None:
    """Write vectors as a set of embeddings."""
    from omnivat.data.embeddings import pairs_of
    from omnivat.data.foreign import import_embeddings
    from omnivat.data.store import manifest_place, require_own, save_embeddings

    if options.look:
        raise SettingsError("--look draws pictures, and a file of vectors has none; leave it out.")
    require_writable(options.out, ".safetensors")
    require_own(manifest_place(options.out, "csv"))
    about = passed(options, "encoder", "preprocessing", "origin", "numbers")
    imported = import_embeddings(options.file, **about, **foreign(options))
    save_embeddings(options.out, imported, dtype=options.dtype)
    header = imported.header
    checked(pairs_of(imported), None)
    print(
        f"{len(imported)} pairs of width {imported.width} by {header.encoder}: domains"
        f" {', '.join(header.domains)}; materials {', '.join(header.classes)}; written to"
        f" {options.out}"
    )


def _pictures(options: argparse.Namespace) -> None:
    """Write pictures of recordings, or those in a file, as a folder of pairs."""
    from omnivat.data.readers import read_pairs
    from omnivat.data.readers.files import table_note
    from omnivat.data.recordings import clips_of, write_pairs

    how = foreign(options)
    how.pop("simulated")
    clips = clips_of(options.file, **passed(options, "vis", "tac", "labels"), **how)
    with progress_bar("import") as show:
        made = write_pairs(
            clips, options.out, **passed(options, "frames", "pick", "align"), on_step=show
        )
    if options.labels and (note := table_note(options.labels)):
        print(f"{options.labels}: {note}")
    for cameras in made.cameras:
        print(f"cameras: {cameras}")
    if made.unequal:
        over = "the time that both films last" if options.align == "time" else "shares of each film"
        more = f"; and {len(made.unequal) - 5} more" if len(made.unequal) > 5 else ""
        print(f"paired over {over}, which differ in length: {'; '.join(made.unequal[:5])}{more}")
    found = read_pairs(options.out)
    origin, simulated = f"'{options.file}'", found.simulated or options.simulated
    skipped = (*made.skipped, *found.skipped)
    checked(replace(found, origin=origin, simulated=simulated, skipped=skipped), options.look)
    print(
        f"{len(found.pairs)} pairs of {len(clips) - len(made.skipped)} recordings; next: python -m"
        f" omnivat try {options.out}"
    )


def checked(pairs: "PairSet", look: Path | None) -> None:
    """Print what a person checks of an imported set, and draw a contact sheet."""
    from omnivat.data.look import contact_sheet
    from omnivat.data.pairs import summary_table

    print(summary_table(pairs), flush=True)
    if not any(pair.object for pair in pairs.pairs):
        print("no pair names its object, so each counts as one: name those that several pairs show")
    if look:
        print(f"{contact_sheet(pairs, look)} pairs are drawn in {look}")


def foreign(options: argparse.Namespace) -> dict[str, Any]:
    """Return what `add_foreign` declares, for a reader."""
    columns = dict(pair.split("=", 1) for pair in options.column)
    return passed(options, "domain", "simulated", "classes") | {"columns": columns}
