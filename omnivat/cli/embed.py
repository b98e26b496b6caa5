"""Embed a set of pairs with a frozen encoder, once.

python -m omnivat embed PAIRS --encoder NAME --out FILE [--precision fp32|bf16|fp32-onnx]
python -m omnivat embed PAIRS --encoder clip-vit-b16 --tac-encoder my_touch.py:load --out FILE
"""

import argparse
from collections.abc import Sequence
from os.path import realpath
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.cli.arguments import (
    DOTS,
    ENCODING,
    declare,
    download,
    encoder_name,
    flag,
    halves,
    one_of,
    passed,
    progress_bar,
    several,
)
from omnivat.cli.imports import checked
from omnivat.data.readers import READERS
from omnivat.data.relief.files import TOUCH, reading_of, touch_of
from omnivat.encoders.base import ENCODERS
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.files import require_writable

ALONE = "alone"
TOUCH_HELP = (
    "read touch in its colours; drawn as its relief (docs/relief.md); or both, one embedding beside"
    " the other"
)
LAMPS = (
    "for the relief: a profile with the lamps of its domain, once or for several domains; alone:"
    " each touch is drawn by itself and nothing is known of a sensor; default: its own touches give"
    " a domain's lamps"
)
if TYPE_CHECKING:
    from omnivat.data.relief import Lamps
    from omnivat.data.store import Header


def add(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("pairs", type=Path, help="a folder or CSV of pairs, or a data set's root")
    words = (
        f"image encoder: {', '.join(ENCODERS)}; hf:NAME_OR_FOLDER for a vision model of"
        " transformers; module:function or file.py:function for your own (docs/encoders.md)"
    )
    declare(
        parser,
        "out",
        *ENCODING[1:],
        "vis",
        "tac",
        "look",
        "tac_rest",
        "flip",
        "channels",
        "workers",
        "device",
        encoder=words,
        seed="of balanced subsampling",
        set="an option of the reader, such as by_folder=true (docs/data.md lists them)",
        reader=one_of(("auto", *READERS), "layout of PAIRS, recognised from the files"),
        strict=flag("no merged or unknown materials"),
        precision=one_of(("fp32", "bf16", "fp32-onnx"), "precision of the encoder"),
        dtype=one_of(("float32", "float16"), "type of the stored vectors"),
        engine=one_of(("local", "ray"), "this machine, or a Ray cluster"),
        manifest=one_of(("csv", "parquet"), "kind of the table next to the embeddings"),
        dots=one_of(DOTS, "printed dots of a gel in tactile images: fill them first, or keep them"),
        touch=one_of(TOUCH, TOUCH_HELP),
        lamps=several(LAMPS, "FILE|alone"),
        no_flips=flag("leave out the mirrored copies"),
    )
    download(parser)


def run(options: argparse.Namespace) -> None:
    """Read the pairs, print a summary, embed them."""
    from omnivat.data.arranged import ways_in, with_ways
    from omnivat.data.readers import read_pairs
    from omnivat.data.rest import with_rest
    from omnivat.data.store import manifest_place
    from omnivat.encoders.embed import embed_pairs

    require_writable(options.out, ".safetensors")
    if realpath(manifest_place(options.out, options.manifest)) == realpath(options.pairs):
        raise SettingsError(
            f"--out is '{options.out}', and its table would replace '{options.pairs}'; choose"
            " another name."
        )
    encoder = encoder_name(options)
    of_reader: dict[str, Any] = halves(options) | dict(t.split("=", 1) for t in options.set)
    pairs = read_pairs(options.pairs, **passed(options, "reader", "strict", "seed"), **of_reader)
    pairs = with_rest(pairs, options.tac_rest or "none")
    pairs = with_ways(pairs, ways_in(options.flip, options.channels, pairs.domains()))
    checked(pairs, options.look)
    if rested := sum(pair.tac_rest is not None for pair in pairs.pairs):
        print(f"{rested} of {len(pairs.pairs)} tactile images have a no-contact picture")
    names = ("weights", "tac_weights", "device", "download", "precision", "dtype", "manifest")
    how = passed(options, *names, "engine", "workers", "dots", "touch")
    how |= {"flips": not options.no_flips, "lamps": lamps_in(options, pairs.domains())}
    with progress_bar(f"embed with {encoder}") as show:
        report = embed_pairs(pairs, encoder, options.out, **how, on_step=show)
    for line in touch_lines(report.header):
        print(line)
    for skipped in report.skipped:
        print(f"skipped {skipped.what}: {skipped.why}")
    resumed = f", {report.resumed} of them by an earlier run" if report.resumed else ""
    print(
        f"{report.embedded} pairs embedded{resumed} in {report.seconds:.0f} s, "
        f"{len(report.skipped)} skipped; written to {report.out}"
    )


def lamps_in(options: argparse.Namespace, domains: Sequence[str]) -> "dict[str, Lamps] | None":
    """Return domain -> lamps of profiles; None if each touch is drawn by itself.

    Raises DataError for a profile without lamps, SettingsError for lamps of touch in its colours.
    """
    from omnivat.data.profile import domain_of
    from omnivat.data.profile_file import load_profile

    if options.lamps and options.touch == TOUCH[0]:
        raise SettingsError(
            "--lamps draw a relief, and touch is read in its colours; add --touch relief or both,"
            " or leave --lamps out."
        )
    if ALONE in options.lamps:
        return None
    found = {}
    for file in options.lamps:
        profile = load_profile(file)
        if profile.lamps is None:
            raise DataError(
                f"The profile '{file}' holds no lamps; make it again from five touches or more."
            )
        found[domain_of(profile, domains, "")] = profile.lamps
    return found


def touch_lines(header: "Header") -> list[str]:
    """Return how the touches of a set were read, and those of each domain arranged and lit, in
    sentences; none for a set without touches, or of vectors that were made elsewhere.
    """
    from omnivat.data.arranged import options_of
    from omnivat.data.foreign import PREFIX

    if "tac" not in header.modalities or header.encoder.startswith(PREFIX):
        return []
    touch, lit = touch_of(header.preprocessing), header.lamps.items()
    return [
        *(f"{name}: touch is read with {options_of(way)}." for name, way in header.tac_way.items()),
        *([] if lit else [f"Touch is read {reading_of(touch, None)}."]),
        *(
            f"{name}: touch is read {reading_of(touch, reading)}."
            + f" {reading}" * isinstance(reading, str)
            for name, reading in lit
        ),
    ]
