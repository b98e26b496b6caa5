"""Embed a set of pairs with a frozen encoder, once.

python -m omnivat embed PAIRS --encoder NAME --out FILE [--precision fp32|bf16|fp32-onnx]
python -m omnivat embed PAIRS --encoder clip-vit-b16 --tac-encoder my_touch.py:load --out FILE
"""

import argparse
from os.path import realpath
from pathlib import Path

from omnivat.cli.arguments import DOTS, declare, download, flag, one_of, passed, path, progress_bar
from omnivat.data.readers import READERS
from omnivat.encoders.base import ENCODERS, JOINED
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import require_writable


def add(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("pairs", type=Path, help="a folder or CSV of pairs, or a data set's root")
    words = (
        f"image encoder: {', '.join(ENCODERS)}; hf:NAME_OR_FOLDER for a vision model of"
        " transformers; module:function or file.py:function for your own (docs/encoders.md)"
    )
    declare(
        parser,
        "out",
        "weights",
        "tac_rest",
        "workers",
        "device",
        encoder=words,
        seed="of balanced subsampling",
        set="an option of the reader, such as by_folder=true (docs/data.md lists them)",
        tac_encoder={
            "metavar": "NAME",
            "help": "another encoder for tactile images; named as above",
        },
        tac_weights=path("checkpoint of --tac-encoder"),
        reader=one_of(("auto", *READERS), "layout of PAIRS, recognised from the files"),
        strict=flag("no merged or unknown materials"),
        precision=one_of(("fp32", "bf16", "fp32-onnx"), "precision of the encoder"),
        dtype=one_of(("float32", "float16"), "type of the stored vectors"),
        engine=one_of(("local", "ray"), "this machine, or a Ray cluster"),
        manifest=one_of(("csv", "parquet"), "kind of the table next to the embeddings"),
        dots=one_of(DOTS, "printed dots of a gel in tactile images: fill them first, or keep them"),
        no_flips=flag("leave out the mirrored copies"),
    )
    download(parser)


def run(options: argparse.Namespace) -> None:
    """Read the pairs, print a summary, embed them."""
    from omnivat.data.pairs import summary_table
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
    if options.tac_weights and not options.tac_encoder:
        raise SettingsError("--tac-weights needs --tac-encoder; without it both use --weights.")
    encoder = JOINED.join(filter(None, (options.encoder, options.tac_encoder)))
    of_reader = dict(text.split("=", 1) for text in options.set)
    found = read_pairs(options.pairs, **passed(options, "reader", "strict", "seed"), **of_reader)
    found = with_rest(found, options.tac_rest or "none")
    print(summary_table(found))
    if rested := sum(pair.tac_rest is not None for pair in found.pairs):
        print(f"a rest picture is subtracted from {rested} of {len(found.pairs)} tactile images")
    names = ("weights", "tac_weights", "device", "download", "precision", "dtype", "manifest")
    how = passed(options, *names, "engine", "workers", "dots") | {"flips": not options.no_flips}
    with progress_bar(f"embed with {encoder}") as show:
        report = embed_pairs(found, encoder, options.out, **how, on_step=show)
    for skipped in report.skipped:
        print(f"skipped {skipped.what}: {skipped.why}")
    resumed = f", {report.resumed} of them by an earlier run" if report.resumed else ""
    print(
        f"{report.embedded} pairs embedded{resumed} in {report.seconds:.0f} s, "
        f"{len(report.skipped)} skipped; written to {report.out}"
    )
