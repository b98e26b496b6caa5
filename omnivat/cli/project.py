"""Draw a map of a set at one stage: x and y of every VIS and TAC point, as a CSV.

python -m omnivat project --out MAP.csv [--stage S] [--order P] [--method umap|pca|umap-learn]
"""

import argparse
import csv
from pathlib import Path

from omnivat.cli.features import StageFeatures, add_stage, stage_features
from omnivat.errors import SettingsError
from omnivat.files import replacing, require_writable
from omnivat.projection import PROJECTIONS

COLUMNS = ("x", "y", "modality", "domain", "class", "pair", "name")
NEIGHBOURS = 15
LEAST = 2 * NEIGHBOURS + 1  # points below which faithfulness has no value


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_stage(parser)
    parser.add_argument("--method", choices=list(PROJECTIONS), default="umap")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, required=True, help="the CSV to write")


def run(options: argparse.Namespace) -> None:
    """Compute the features, lay them out, write the CSV, print how faithful the map is."""
    if options.out.suffix.lower() != ".csv":
        raise SettingsError(f"--out is '{options.out}'; name a file that ends in .csv.")
    require_writable(options.out)
    import torch

    from omnivat.gaps.unit import unit
    from omnivat.projection.quality import recall, trustworthiness
    from omnivat.tables import load

    found = stage_features(options)
    points = unit(torch.cat([found.rows["vis"], found.rows["tac"]]))
    flat = load(PROJECTIONS, options.method, kind="map")(points, seed=options.seed)
    with (
        replacing(options.out) as temporary,
        temporary.open("w", newline="", encoding="utf-8") as handle,
    ):
        writer = csv.writer(handle)
        writer.writerow(COLUMNS)
        writer.writerows(_rows(found, flat.tolist()))
    print(f"{options.method} of {options.stage}: {found.about}")
    if len(points) >= LEAST:
        print(
            f"trustworthiness {trustworthiness(points, flat, k=NEIGHBOURS):.4f}, "
            f"recall {recall(points, flat, k=NEIGHBOURS):.4f} at {NEIGHBOURS} neighbours "
            "(1 is a faithful map)"
        )
    print(f"{len(points)} points written to {options.out}")


def _rows(found: StageFeatures, flat: list[list[float]]) -> list[list[str]]:
    """Return one row a point: all VIS, then all TAC, in the order of the pairs."""
    embeddings = found.embeddings
    header, count = embeddings.header, len(embeddings)
    rows = []
    for point, (x, y) in enumerate(flat):
        modality, pair = ("vis", "tac")[point // count], point % count
        rows.append(
            [
                f"{x:.6g}",
                f"{y:.6g}",
                modality,
                header.domains[int(embeddings.domain[pair])],
                header.classes[int(embeddings.label[pair])],
                str(pair),
                embeddings.rows[modality][pair],
            ]
        )
    return rows
