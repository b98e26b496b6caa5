"""Import embeddings from another program: NPZ, Parquet, HDF5 or a CSV of vectors.

python -m omnivat import FILE --encoder NAME --out set.safetensors [--domain NAME] [--column material=class]
"""

import argparse
from pathlib import Path

from omnivat.errors import SettingsError
from omnivat.files import require_writable


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("file", type=Path, help=".npz, .parquet, .h5 or .csv (docs/encoders.md)")
    parser.add_argument("--out", type=Path, required=True, help="the .safetensors file to write")
    parser.add_argument(
        "--encoder", required=True, metavar="NAME", help="name of the vectors' encoder"
    )
    parser.add_argument("--domain", default="", help="of all pairs, if the file has none")
    parser.add_argument("--classes", default="", help="names of numbered materials, with commas")
    parser.add_argument(
        "--column",
        action="append",
        default=[],
        metavar="OURS=THEIRS",
        help="another name of a column, such as material=label; can be given several times",
    )
    parser.add_argument("--preprocessing", default="", help="preprocessing of the images")
    parser.add_argument("--origin", default="", help="one line on the file's origin")
    parser.add_argument("--simulated", action="store_true", help="the pairs are simulated")
    parser.add_argument(
        "--dtype", choices=["float32", "float16"], default="float32", help="of the written file"
    )


def run(options: argparse.Namespace) -> None:
    """Read, check, write; print a summary."""
    from omnivat.data.foreign import import_embeddings
    from omnivat.data.manifest import manifest_place, require_own
    from omnivat.data.store import save_embeddings

    require_writable(options.out, ".safetensors")
    require_own(manifest_place(options.out, "csv"))
    found = import_embeddings(
        options.file,
        encoder=options.encoder,
        domain=options.domain,
        classes=[name.strip() for name in options.classes.split(",") if name.strip()],
        columns=_columns(options.column),
        preprocessing=options.preprocessing,
        origin=options.origin,
        simulated=options.simulated,
    )
    save_embeddings(options.out, found, dtype=options.dtype)
    header = found.header
    print(
        f"{len(found)} pairs of width {found.width} by {header.encoder}: domains "
        f"{', '.join(header.domains)}; materials {', '.join(header.classes)}; written to {options.out}"
    )


def _columns(texts: list[str]) -> dict[str, str]:
    for text in texts:
        if not all(text.partition("=")):
            raise SettingsError(f"--column got '{text}'; write it as OURS=THEIRS.")
    return {ours: theirs for ours, _, theirs in (text.partition("=") for text in texts)}
