"""Is the simulated set any good? Linear probe, sensors told apart, modality gap, real images placed.

    python -m omnivat simulate --out DIR
    python -m benchmarks.simulated --pairs DIR [--real DIR] [--features FILE.npz]

Prints tables in Markdown; `docs/simulated.md` holds what they said.
"""

import argparse
import csv
import logging
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.simulated_probe import Accuracy, accuracy, probe_matrix, sensor_accuracy
from omnivat.data.domains import DOMAINS, paper_name
from omnivat.errors import DataError

Array = NDArray[np.float32]
_BATCH = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class Features:
    """Unit-length embeddings of a set: (N, D) each, and a row of pairs.csv for each."""

    vis: Array
    tac: Array
    rows: list[dict[str, str]]

    def column(self, name: str) -> NDArray[np.str_]:
        """Return one column of pairs.csv."""
        return np.array([row[name] for row in self.rows])


def main() -> None:
    """Print every table."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=Path, required=True, help="a folder with pairs.csv")
    parser.add_argument("--real", type=Path, help="a folder with real *_tac.png images")
    parser.add_argument("--features", type=Path, help="keep the embeddings here for the next run")
    given = parser.parse_args()
    features = features_of(given.pairs, given.features)
    print(f"{len(features.rows)} pairs, EfficientNet-Lite0 features of unit length.\n")
    print_probe(features)
    print_sensors(features)
    print_gaps(features)
    if given.real:
        print_real(features, given.real)


def features_of(pairs: Path, kept: Path | None) -> Features:
    """Return the embeddings of all images that `pairs/pairs.csv` lists, from `kept` if it is there."""
    table = pairs / "pairs.csv"
    if not table.exists():
        raise DataError(f"'{table}' is not there; make it with `python -m omnivat simulate`.")
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    if kept and kept.exists():
        with np.load(kept) as arrays:
            if len(arrays["vis"]) == len(rows):
                return Features(vis=arrays["vis"], tac=arrays["tac"], rows=rows)
    vis = embedded([pairs / row["vis"] for row in rows])
    tac = embedded([pairs / row["tac"] for row in rows])
    if kept:
        np.savez(kept, vis=vis, tac=tac)
    return Features(vis=vis, tac=tac, rows=rows)


def embedded(files: list[Path]) -> Array:
    """Return the default encoder's embeddings of image files, each of unit length."""
    import torch
    from PIL import Image

    from omnivat.encoders.base import DEFAULT_ENCODER, load_encoder

    encoder = load_encoder(DEFAULT_ENCODER)
    parts = []
    with torch.no_grad():
        for start in range(0, len(files), _BATCH):
            images = [Image.open(file).convert("RGB") for file in files[start : start + _BATCH]]
            parts.append(
                encoder.embed(torch.stack([encoder.preprocess(i) for i in images])).numpy()
            )
    all_ = np.concatenate(parts).astype(np.float32)
    return np.asarray(all_ / np.linalg.norm(all_, axis=1, keepdims=True))


def print_probe(features: Features) -> None:
    """Print linear-probe accuracy from each domain to each, for VIS, TAC and both."""
    both = np.concatenate([features.vis, features.tac], axis=1)
    for name, values in (("VIS + TAC", both), ("VIS", features.vis), ("TAC", features.tac)):
        matrix = probe_matrix(
            values,
            materials=features.column("material"),
            domains=features.column("domain"),
            splits=features.column("split"),
        )
        _print_matrix(name, matrix)


def _print_matrix(name: str, matrix: dict[tuple[str, str], Accuracy]) -> None:
    domains = list(dict.fromkeys(source for source, _ in matrix))
    within = [matrix[domain, domain].share for domain in domains]
    across = [cell.share for (source, target), cell in matrix.items() if source != target]
    print(f"## Linear probe, {name} (%)\n")
    print("| from \\ to | " + " | ".join(map(paper_name, domains)) + " | others |")
    print("| --- |" + " ---: |" * (len(domains) + 1))
    for source in domains:
        cells = [100 * matrix[source, target].share for target in domains]
        others = np.mean([c for c, target in zip(cells, domains, strict=True) if target != source])
        shown = [
            f"**{c:.0f}**" if target == source else f"{c:.0f}"
            for c, target in zip(cells, domains, strict=True)
        ]
        print(f"| {paper_name(source)} | " + " | ".join(shown) + f" | {others:.0f} |")
    print(
        f"\nWithin: mean {100 * np.mean(within):.1f}, least {100 * min(within):.1f}. "
        f"Across: mean {100 * np.mean(across):.1f}, from {100 * min(across):.1f} "
        f"to {100 * max(across):.1f}.\n"
    )


def print_sensors(features: Features) -> None:
    """Print how well the nearest neighbour of a TAC image tells its sensor."""
    shares = sensor_accuracy(
        features.tac, domains=features.column("domain"), splits=features.column("split")
    )
    print(
        "## Sensor told by the nearest TAC neighbour (test objects against training objects, %)\n"
    )
    print("| domain | sensor | right |\n| --- | --- | ---: |")
    for domain, cell in shares.items():
        print(f"| {paper_name(domain)} | {_sensor(domain)} | {100 * cell.share:.0f} |")
    whole = accuracy(*(sum(getattr(c, f) for c in shares.values()) for f in ("right", "of")))
    print(f"\nAll: {100 * whole.share:.1f} of {whole.of} images.\n")


def print_gaps(features: Features) -> None:
    """Print the distance between the VIS and TAC centroids, and the spread round each."""
    print("## Modality gap (unit vectors)\n")
    print(
        "| domain | between centroids | spread of VIS | spread of TAC |\n| --- | ---: | ---: | ---: |"
    )
    domains = features.column("domain")
    for domain in dict.fromkeys(domains):
        vis, tac = features.vis[domains == domain], features.tac[domains == domain]
        gap = np.linalg.norm(vis.mean(0) - tac.mean(0))
        spreads = [np.linalg.norm(x - x.mean(0), axis=1).mean() for x in (vis, tac)]
        print(f"| {paper_name(domain)} | {gap:.2f} | {spreads[0]:.2f} | {spreads[1]:.2f} |")
    print()


def print_real(features: Features, folder: Path) -> None:
    """Print which simulated sensors real tactile images lie nearest to."""
    files = sorted(folder.rglob("*_tac.png"))
    if not files:
        raise DataError(f"'{folder}' holds no image whose name ends in _tac.png.")
    closeness = embedded(files) @ features.tac.T
    domains = features.column("domain")
    print("## Real tactile images: simulated domains of their five nearest neighbours\n")
    print("| real folder | images | nearest | five nearest |\n| --- | ---: | --- | --- |")
    for parent in dict.fromkeys(file.parent for file in files):
        chosen = closeness[[file.parent == parent for file in files]]
        order = np.argsort(-chosen, axis=1)[:, :5]
        first = Counter(map(str, domains[order[:, 0]]))
        five = Counter(map(str, domains[order.ravel()]))
        print(f"| {parent.name} | {len(chosen)} | {_said(first)} | {_said(five)} |")
    print()


def _said(counts: Counter[str]) -> str:
    return ", ".join(f"{paper_name(name)} {count}" for name, count in counts.most_common())


def _sensor(domain: str) -> str:
    return DOMAINS[paper_name(domain)].sensor


if __name__ == "__main__":
    main()
