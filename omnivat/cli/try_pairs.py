"""Try your own pairs: embed, train a small head, honest figures, one folder, then the page.

python -m omnivat try PAIRS [--out DIR] [--source DOMAIN] [--no-page]

PAIRS: a folder or CSV of pictures, an embeddings file, or vectors as NPZ, Parquet, HDF5 or CSV, or
the name of a set that `fetch` lists. One domain, one modality, no classes and two pairs are
accepted.
"""

import argparse
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.cli.arguments import (
    ENCODING,
    declare,
    download,
    encoder_name,
    flag,
    halves,
    one_of,
    passed,
    path,
    progress_bar,
    several,
    text,
)
from omnivat.cli.embed import LAMPS, TOUCH_HELP, lamps_in, touch_lines
from omnivat.cli.fetch import bring
from omnivat.cli.imports import add_foreign, checked, foreign
from omnivat.cli.thumbnails import start_of
from omnivat.data.naming import half_of
from omnivat.data.readers.files import TABLES, numbered_rows
from omnivat.data.relief.files import TOUCH
from omnivat.encoders.base import DEFAULT_ENCODER
from omnivat.head.heads import HEAD, SET
from omnivat.kit.errors import DataError, SettingsError, printable
from omnivat.kit.files import nothing_left, replacing, require_regular, require_writable, write_json
from omnivat.kit.stages import IMAGES

if TYPE_CHECKING:
    from omnivat.study.shift import Features

SUMMARY = "summary.txt"
PAGE = "from app.serving.server import main; raise SystemExit(main())"


def add(parser: argparse.ArgumentParser) -> None:
    words = "a folder, CSV, NPZ, Parquet, or a set of fetch"
    parser.add_argument("pairs", type=Path, metavar="PAIRS", help=words)
    add_foreign(parser)
    declare(
        parser,
        *ENCODING,
        "vis",
        "tac",
        "look",
        "tac_rest",
        "flip",
        "channels",
        "seed",
        "device",
        "target",
        out=path("folder to write; default: beside PAIRS", "DIR"),
        source=text("domain to train on; default: the largest"),
        touch=one_of(TOUCH, TOUCH_HELP),
        lamps=several(LAMPS, "FILE|alone"),
        no_page=flag("write the folder, open no page"),
    )
    download(parser)


def run(options: argparse.Namespace) -> None:
    """Read or embed, train, print the figures, write the folder, open the page."""
    from omnivat.data.fetching import fetched_sets

    place = options.pairs
    if not place.exists() and str(place) in fetched_sets():
        bring(str(place), place)
    if not place.exists():
        raise DataError(f"There is no folder or file at '{printable(str(place))}'. Check the path.")
    whole = place.resolve()
    out = options.out or whole.with_name(f"{whole.stem if whole.is_file() else whole.name}-try")
    if out.is_file():
        raise SettingsError(f"--out is the file '{out}'; name a folder.")
    if (out / SET).resolve() == whole:
        raise SettingsError(f"--out would replace '{place}'; name another folder.")
    from omnivat.head.checkpoint import require_head_folder

    require_head_folder(out / HEAD)
    for name in (SET, SUMMARY):
        require_writable(out / name)
    with nothing_left(out):
        _write(options, out)
    if options.no_page:
        return
    command = [sys.executable, "-c", PAGE, "--embeddings", str(out / SET)]
    # without one, the page shows the set through the project's, or its features alone
    if (out / HEAD).is_dir():
        command += ["--head", str(out / HEAD)]
    print(f"The page again: python app.py {' '.join(command[3:])}", flush=True)
    with subprocess.Popen(command) as page:
        try:
            page.wait()
        except KeyboardInterrupt:  # the page gets it, too, and cleans up
            page.wait()


def _write(options: argparse.Namespace, out: Path) -> None:
    """Read or embed, train, print the figures, write the folder."""
    from omnivat.data.profile import profile_of
    from omnivat.data.profile_file import save_profile
    from omnivat.head.checkpoint import save_head
    from omnivat.measure.card.of_set import differences
    from omnivat.study.comparison import predicted_numbers, sentence
    from omnivat.study.trial import try_pairs

    features, notes = _features(options, out)
    notes += touch_lines(features.embeddings.header)
    classes = len({*features.embeddings.label.tolist()}) if features.labelled else 0
    alone = {"vis": "photos alone", "tac": "touches alone"}.get("+".join(features.modalities))
    notes.append(
        f"{len(features.embeddings)} pairs, {len(features.domains)} domain(s): "
        f"{', '.join(map(printable, features.domains))}; {classes or 'no'} classes"
        + (f"; {alone}: the page draws each twice." if alone else ".")
    )
    notes += differences(features.embeddings, options.source)
    print("\n".join(notes), flush=True)
    with progress_bar("train and test") as show:
        trial = try_pairs(features, source=options.source, seed=options.seed, on_step=show)
    if options.target:
        measured = predicted_numbers(features, options.target, seed=options.seed)
        trial.lines.append(sentence(options.target, measured))
        trial.records.append({"target": options.target, "columns": measured})
    print("\n".join(trial.lines))
    for k, name in enumerate(features.domains):
        profile = profile_of(
            features.embeddings, features.members(name), domain=name, modalities=features.modalities
        )
        plain = "".join(letter if letter.isalnum() else "-" for letter in name)[:60]
        save_profile(out / "profiles" / f"{k + 1}-{plain}.safetensors", profile)
    if trial.head is not None:
        save_head(out / HEAD, trial.head)
    else:
        shutil.rmtree(out / HEAD, ignore_errors=True)  # of an earlier set
    write_json(out / "figures.json", trial.records)
    with replacing(out / SUMMARY) as temporary:
        temporary.write_text("\n".join([*notes, *trial.lines, ""]), encoding="utf-8")
    print(
        f"Everything is in {out}: {SET}, {len(features.domains)} profiles, {SUMMARY}, figures.json"
    )


def _features(options: argparse.Namespace, out: Path) -> tuple["Features", list[str]]:
    """Return the set, which is then in `out`, and notes on it."""
    from omnivat.data.store import save_embeddings
    from omnivat.maps.thumbnails import sheet_of
    from omnivat.study.shift import read_features

    place, notes = options.pairs, []
    pictures = place.is_dir() or (place.suffix.lower() in TABLES and _of_pictures(place))
    if pictures:
        notes = _embed(options, out)
    of_file = foreign(options)
    features = read_features(
        out / SET if pictures else place,
        encoder="" if options.encoder == DEFAULT_ENCODER else options.encoder,
        **{**of_file, "columns": {**halves(options), **of_file["columns"]}},
        numbers=tuple(filter(None, [options.target])),
        seed=options.seed,
    )
    if features.drawn_of > len(features.embeddings):
        notes.append(
            f"{len(features.embeddings):,} of {features.drawn_of:,} pairs, drawn at random."
        )
        pictures = False  # the sheet of thumbnails is of all pairs
        sheet_of(out / SET).unlink(missing_ok=True)
    if any(features.embeddings.rows["split"]):
        notes.append("The set's split is not used: whole objects are left out instead.")
        features, pictures = replace(features, embeddings=features.embeddings.unsplit), False
    if not pictures:
        save_embeddings(out / SET, features.embeddings)
    return features, notes


def _of_pictures(table: Path) -> bool:
    """True for a table whose first row has a column of photos or touches: names of files, not
    numbered columns of vectors.
    """
    require_regular(table)
    header = next(iter(numbered_rows(table).values()), [])
    plain = [name for name in header if not re.search(r"_\d+$", name)]
    return any(half_of(name) in IMAGES for name in plain) or len(plain) == len(header)


def _embed(options: argparse.Namespace, out: Path) -> list[str]:
    """Embed the pictures into `out`, with thumbnails; return notes."""
    from omnivat.data.arranged import ways_in, with_ways
    from omnivat.data.readers import read_pairs
    from omnivat.data.rest import with_rest
    from omnivat.data.store import load_embeddings
    from omnivat.encoders.embed import embed_pairs
    from omnivat.maps.thumbnails import sheet_of, write_thumbnails

    of_reader: dict[str, Any] = halves(options)
    pairs = with_rest(read_pairs(options.pairs, **of_reader), options.tac_rest or "none")
    pairs = with_ways(pairs, ways_in(options.flip, options.channels, pairs.domains()))
    checked(pairs, options.look)
    encoder = encoder_name(options)
    how = passed(options, "weights", "tac_weights", "device", "download", "touch")
    how |= {"lamps": lamps_in(options, pairs.domains())}
    with progress_bar(f"embed with {encoder}") as show:
        report = embed_pairs(pairs, encoder, out / SET, **how, on_step=show)
    notes = [f"Skipped {skip.what}: {skip.why}" for skip in report.skipped]
    embeddings = load_embeddings(out / SET)
    files = [pair.vis.absolute() for pair in pairs.pairs]
    root = start_of(options.pairs, embeddings.rows["vis"], files)
    try:
        with progress_bar("thumbnails") as show:
            write_thumbnails(embeddings, root, sheet_of(out / SET), on_step=show)
    except DataError as error:
        notes.append(f"No thumbnails: {error}")
    return notes
