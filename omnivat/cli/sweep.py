"""Compute every frame of the page, and the gaps, for a head over all orders p.

python -m omnivat sweep --head DIR --embeddings FILE --out FRAMES [--json CURVES]
"""

import argparse
from pathlib import Path

from omnivat.cli.bar import progress_bar
from omnivat.errors import SettingsError
from omnivat.heads import default_embeddings, default_head


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--head", type=Path, default=default_head())
    parser.add_argument("--embeddings", type=Path, default=default_embeddings())
    parser.add_argument("--out", type=Path, required=True, help="the frames file for the page")
    parser.add_argument("--json", type=Path, help="also write the curves over p as JSON")
    parser.add_argument("--stops", type=int, default=101, help="orders from 0 to 1")


def run(options: argparse.Namespace) -> None:
    """Build the frames, write them, print the curves' ends."""
    if not 2 <= options.stops <= 1001:
        raise SettingsError(f"--stops is {options.stops}; choose 2 to 1001.")
    from omnivat.checkpoint import head_hash, load_head
    from omnivat.data.store import load_embeddings
    from omnivat.files import write_json
    from omnivat.frames import build_frames, write_frames

    head, embeddings = load_head(options.head), load_embeddings(options.embeddings)
    head.require_embeddings(embeddings)
    orders = [step / (options.stops - 1) for step in range(options.stops)]
    provenance = {
        "hash": head_hash(options.head),
        "source": head.source,
        "order": head.model.order,
        "simulated": head.provenance.get("simulated", False),
    }
    with progress_bar("sweep") as show:
        frames = build_frames(
            head.model, embeddings, orders=orders, provenance=provenance, on_step=show
        )
    write_frames(options.out, frames)
    if options.json:
        write_json(options.json, {"orders": orders, "head": provenance, "curves": frames.curves})
    print(f"{'curve':<28} {'p = 0':>9} {'p = 0.5':>9} {'p = 1':>9}")
    for name, values in frames.curves.items():
        picked = (values[0], values[len(values) // 2], values[-1])
        print(f"{name:<28} " + " ".join(_number(value) for value in picked))
    print(f"{options.stops} stops of {len(embeddings)} pairs written to {options.out}")


def _number(value: float | None) -> str:
    return f"{'-':>9}" if value is None else f"{value:>9.4f}"
