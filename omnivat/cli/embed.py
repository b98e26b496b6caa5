"""Embed a set of pairs with a frozen encoder, once.

python -m omnivat embed PAIRS --encoder NAME --out FILE [--precision fp32|bf16|fp32-onnx]
"""

import argparse
from pathlib import Path

from omnivat.cli.bar import progress_bar
from omnivat.data.readers import READERS
from omnivat.encoders.base import DEFAULT_ENCODER, ENCODERS
from omnivat.errors import SettingsError
from omnivat.files import require_writable


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("pairs", type=Path, help="a folder or CSV of pairs, or a data set's root")
    parser.add_argument("--encoder", choices=ENCODERS, default=DEFAULT_ENCODER)
    parser.add_argument("--out", type=Path, required=True, help="the .safetensors file to write")
    parser.add_argument("--weights", type=Path, help="checkpoint of the encoder")
    parser.add_argument("--reader", choices=["auto", *READERS], default="auto")
    parser.add_argument("--strict", action="store_true", help="no merged or unknown materials")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="key=value",
        help="an option of the reader, such as by_folder=true (docs/data.md lists them)",
    )
    parser.add_argument("--seed", type=int, default=0, help="of balanced subsampling")
    parser.add_argument("--precision", choices=["fp32", "bf16", "fp32-onnx"], default="fp32")
    parser.add_argument(
        "--device", default="cpu", help="cpu, cuda, or auto: a GPU if there is one (not run in CI)"
    )
    parser.add_argument("--dtype", choices=["float32", "float16"], default="float32")
    parser.add_argument("--engine", choices=["local", "ray"], default="local")
    parser.add_argument("--manifest", choices=["csv", "parquet"], default="csv")
    parser.add_argument("--no-flips", action="store_true", help="leave out the mirrored copies")
    parser.add_argument("--workers", type=int, help="threads; all cores if left out")


def run(options: argparse.Namespace) -> None:
    """Read the pairs, say what was found, embed them."""
    from omnivat.data.manifest import manifest_place
    from omnivat.data.pairs import summary_table
    from omnivat.data.readers import read_pairs
    from omnivat.embed import embed_pairs

    require_writable(options.out, ".safetensors")
    if manifest_place(options.out, options.manifest).resolve() == options.pairs.resolve():
        raise SettingsError(
            f"--out is '{options.out}', and the table beside it would replace '{options.pairs}'; "
            "choose another name."
        )
    found = read_pairs(
        options.pairs,
        reader=options.reader,
        strict=options.strict,
        seed=options.seed,
        **reader_options(options.set),
    )
    print(summary_table(found))
    with progress_bar(f"embed with {options.encoder}") as show:
        report = embed_pairs(
            found,
            options.encoder,
            options.out,
            weights=options.weights,
            device=options.device,
            precision=options.precision,
            dtype=options.dtype,
            manifest=options.manifest,
            engine=options.engine,
            flips=not options.no_flips,
            workers=options.workers,
            on_step=show,
        )
    for skipped in report.skipped:
        print(f"skipped {skipped.what}: {skipped.why}")
    resumed = f", {report.resumed} of them by an earlier run" if report.resumed else ""
    print(
        f"{report.embedded} pairs embedded{resumed} in {report.seconds:.0f} s, "
        f"{len(report.skipped)} skipped; written to {report.out}"
    )


def reader_options(texts: list[str]) -> dict[str, str]:
    """Return {option: text} for `key=value` texts. Raises SettingsError for one without "="."""
    for text in texts:
        if "=" not in text:
            raise SettingsError(f"--set got '{text}'; write it as key=value.")
    return {name: value for name, _, value in (text.partition("=") for text in texts)}
