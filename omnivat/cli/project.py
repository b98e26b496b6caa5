"""Draw a map of a set at one stage: x and y of every VIS and TAC point, as a CSV.

python -m omnivat project --out MAP.csv [--stage S] [--order P] [--method umap|pca|umap-learn]
"""

import argparse
import csv
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from omnivat.cli.arguments import add_seed
from omnivat.cli.features import StageFeatures, add_stage, stage_features
from omnivat.errors import SettingsError
from omnivat.files import replacing, require_writable
from omnivat.projection import PROJECTIONS

if TYPE_CHECKING:
    from torch import Tensor

    from omnivat.projection.quality import Quality

COLUMNS = ("x", "y", "modality", "domain", "class", "pair", "name")
NEIGHBOURS = 15
LEAST = 2 * NEIGHBOURS + 1  # fewest points for a faithfulness value


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_stage(parser)
    parser.add_argument(
        "--method",
        choices=list(PROJECTIONS),
        default="umap",
        help="method of the map; default: umap",
    )
    add_seed(parser, of="the layout")
    parser.add_argument("--out", type=Path, required=True, help="the CSV to write")


def run(options: argparse.Namespace) -> None:
    """Compute the features, map them, write the CSV, print the faithfulness."""
    if options.out.suffix.lower() != ".csv":
        raise SettingsError(f"--out is '{options.out}'; name a file that ends in .csv.")
    require_writable(options.out)
    from omnivat.projection.quality import quality
    from omnivat.projection.torch_umap import MOST_ROWS
    from omnivat.tables import load

    found = stage_features(options)
    points = found.points
    flat = load(PROJECTIONS, options.method, kind="map")(points, seed=options.seed)
    with (
        replacing(options.out) as temporary,
        temporary.open("w", newline="", encoding="utf-8") as handle,
    ):
        writer = csv.writer(handle)
        writer.writerow(COLUMNS)
        writer.writerows(_rows(found, flat))
    print(f"{options.method} of {options.stage}: {found.about}")
    if len(points) >= LEAST:
        print(faithfulness(quality(points, flat, k=NEIGHBOURS)))
    if options.method == "umap" and len(points) > MOST_ROWS:
        print(f"{MOST_ROWS:,} points were mapped; the others are placed between their neighbours")
    print(f"{len(points)} points written to {options.out}")


def faithfulness(found: "Quality") -> str:
    """Return a line with the faithfulness of a map, with intervals if rows were sampled."""
    drawn = found.trustworthiness_error > 0
    trust, recall = (
        f"{value:.4f}" + (f" ± {error:.4f}" if drawn else "")
        for value, error in (
            (found.trustworthiness, found.trustworthiness_error),
            (found.recall, found.recall_error),
        )
    )
    of = f", from {found.rows:,} points drawn at random" if drawn else ""
    return (
        f"trustworthiness {trust}, recall {recall} at {NEIGHBOURS} neighbours (1 is a faithful "
        f"map){of}"
    )


def _rows(found: StageFeatures, flat: "Tensor") -> Iterator[list[str]]:
    """Yield one row for each point: all VIS, then all TAC, in the order of the pairs."""
    embeddings = found.embeddings
    header, count = embeddings.header, len(embeddings)
    for point, place in enumerate(flat):
        x, y = place.tolist()
        modality, pair = ("vis", "tac")[point // count], point % count
        yield [
            f"{x:.6g}",
            f"{y:.6g}",
            modality,
            header.domains[int(embeddings.domain[pair])],
            header.classes[int(embeddings.label[pair])],
            str(pair),
            embeddings.rows[modality][pair],
        ]
