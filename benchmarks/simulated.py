"""Quality of the simulated set: probes on sight, touch and both; look-alikes; sensors; real pairs.

    python -m benchmarks.simulated                      # of the shipped embeddings
    python -m benchmarks.simulated --pairs DIR          # of a set on disk, embedded first
    ... [--real DIR] [--examples examples/pairs] [--matrices]

Prints tables in Markdown; `docs/simulated.md` shows them.
"""

import argparse
import logging
from pathlib import Path

import numpy as np

from benchmarks.simulated_features import SHIPPED, Features, embedded, features_in, features_of
from benchmarks.simulated_probe import READINGS, Accuracy, judged, read_all, sensor_accuracy
from benchmarks.simulated_real import print_real, real_pairs
from benchmarks.simulated_table import print_imitations, print_matrix, print_table
from omnivat.data.domains import DOMAINS, paper_name
from omnivat.encoders.base import DEFAULT_ENCODER
from omnivat.kit.errors import DataError


def main() -> None:
    """Print every table."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    given = _parser().parse_args()
    features = features_of(given.pairs) if given.pairs else features_in(given.embeddings)
    print(f"{len(features.rows)} pairs, {DEFAULT_ENCODER} features of unit length.\n")
    found = judged(features)
    print_table(found, features)
    print_imitations(found, features)
    for reading in READINGS if given.matrices else ():
        print_matrix(found, features, reading)
    print_sensors(features)
    print_gaps(features)
    if given.real:
        print_real(features, real_pairs(given.real))
    if given.examples:
        print_examples(features, given.examples)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    source = parser.add_mutually_exclusive_group()
    source.add_argument("--embeddings", type=Path, default=SHIPPED, help="file of the embed command")
    source.add_argument("--pairs", type=Path, help="a folder with pairs.csv, to embed first")
    parser.add_argument("--real", type=Path, help="a folder of real pairs with labels.csv")
    parser.add_argument("--examples", type=Path, help="example pairs to compare with the set's own")
    parser.add_argument("--matrices", action="store_true", help="also from each domain to each")
    return parser


def print_sensors(features: Features) -> None:
    """Print how often the nearest TAC neighbour has the same sensor."""
    shares = sensor_accuracy(features.tac, domains=features.column("domain"), splits=features.column("split"))
    print("## Sensor identified by the nearest TAC neighbour (test pairs against training pairs, %)\n")
    print("| domain | sensor | right |\n| --- | --- | ---: |")
    for domain, cell in shares.items():
        sensor = DOMAINS[paper_name(domain)].sensor
        print(f"| {paper_name(domain)} | {sensor} | {100 * cell.share:.0f} |")
    right, of = (sum(getattr(cell, name) for cell in shares.values()) for name in ("right", "of"))
    whole = Accuracy(right=right, of=of)
    print(f"\nAll: {100 * whole.share:.1f} of {whole.of} images.\n")


def print_gaps(features: Features) -> None:
    """Print the distance between the VIS and TAC centroids, and the spread around each."""
    print("## Modality gap (unit vectors)\n")
    print("| domain | between centroids | spread of VIS | spread of TAC |\n| --- | ---: | ---: | ---: |")
    domains = features.column("domain")
    for domain in dict.fromkeys(map(str, domains)):
        vis, tac = features.vis[domains == domain], features.tac[domains == domain]
        gap = np.linalg.norm(vis.mean(0) - tac.mean(0))
        spreads = [np.linalg.norm(x - x.mean(0), axis=1).mean() for x in (vis, tac)]
        print(f"| {paper_name(domain)} | {gap:.2f} | {spreads[0]:.2f} | {spreads[1]:.2f} |")
    print()


def print_examples(features: Features, folder: Path) -> None:
    """Print the similarity between embeddings of lossy example images and of the originals.

    It has the cosine, and the agreement of probes trained on all training pairs.
    """
    place = {(row["domain"], Path(row["vis"]).stem): i for i, row in enumerate(features.rows)}
    files = sorted(folder.glob("*/*/*_vis.jpg"))
    known = [(f, place.get((f.parent.parent.name, f.stem))) for f in files]
    lost = [file for file, index in known if index is None]
    if lost or not files:
        raise DataError(f"'{(lost or [folder])[0]}' is no example of this set; make both anew.")
    own = np.array([index for _, index in known])
    vis = embedded(files)
    tac = embedded([f.with_name(f.name.replace("_vis.", "_tac.")) for f in files])
    materials = features.column("material")
    found = read_all(
        np.concatenate([features.vis, vis]),
        np.concatenate([features.tac, tac]),
        np.concatenate([features.column("split") == "train", np.zeros(len(own), dtype=bool)]),
        np.concatenate([materials, materials[own]]),
    )["concatenation"]
    print("## Example images, lossy, against the images that were embedded\n")
    print("| | images | least cosine | mean cosine |\n| --- | ---: | ---: | ---: |")
    for name, here, there in (("VIS", vis, features.vis[own]), ("TAC", tac, features.tac[own])):
        near = (here * there).sum(1)
        print(f"| {name} | {len(near)} | {near.min():.3f} | {near.mean():.3f} |")
    same = (found[own] == found[len(materials) :]).sum()
    print(f"\nThe same material is predicted for {same} of {len(own)} pairs.\n")


if __name__ == "__main__":
    main()
