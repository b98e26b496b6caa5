"""Is the simulated set any good? Linear probe, sensors told apart, modality gap, real images placed.

    python -m benchmarks.simulated                      # of the shipped embeddings
    python -m benchmarks.simulated --pairs DIR          # of a set on disk, embedded first
    ... [--real DIR] [--examples examples/pairs]

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

from benchmarks.simulated_probe import (
    Accuracy,
    accuracy,
    cross_validated,
    fitted,
    probe_matrix,
    sensor_accuracy,
    within_with,
)
from omnivat.data.domains import DOMAINS, paper_name
from omnivat.data.store import load_embeddings
from omnivat.encoders.base import DEFAULT_ENCODER
from omnivat.errors import DataError
from omnivat.simulate.plan import classes, planned

Array = NDArray[np.float32]
SHIPPED = Path("examples/simulated.safetensors")
_BATCH = 32
OBJECTS, TEST_OBJECTS = 40, 12  # of each class of each domain in the shipped set


@dataclass(frozen=True, slots=True, kw_only=True)
class Features:
    """Unit-length embeddings of a set: (N, D) each, and a row of pairs.csv for each."""

    vis: Array
    tac: Array
    rows: list[dict[str, str]]

    @property
    def both(self) -> Array:
        """VIS and TAC of each pair side by side, (N, 2D)."""
        return np.concatenate([self.vis, self.tac], axis=1)

    def column(self, name: str) -> NDArray[np.str_]:
        """Return one column of pairs.csv."""
        return np.array([row[name] for row in self.rows])


def main() -> None:
    """Print every table."""
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    parser = argparse.ArgumentParser(description=__doc__)
    source = parser.add_mutually_exclusive_group()
    source.add_argument(
        "--embeddings", type=Path, default=SHIPPED, help="file of the embed command"
    )
    source.add_argument("--pairs", type=Path, help="a folder with pairs.csv, to embed first")
    parser.add_argument("--real", type=Path, help="a folder with real *_tac.png images")
    parser.add_argument("--examples", type=Path, help="example pairs to compare with the set's own")
    given = parser.parse_args()
    features = features_of(given.pairs) if given.pairs else features_in(given.embeddings)
    print(f"{len(features.rows)} pairs, {DEFAULT_ENCODER} features of unit length.\n")
    print_probe(features)
    print_growth(features)
    print_other_splits(features)
    print_strengths(features)
    print_sensors(features)
    print_gaps(features)
    if given.real:
        print_real(features, given.real)
    if given.examples:
        print_examples(features, given.examples)


def features_in(file: Path) -> Features:
    """Return what a file of embeddings holds."""
    kept = load_embeddings(file)
    if not kept.header.encoder == DEFAULT_ENCODER:
        raise DataError(f"'{file}' holds {kept.header.encoder}; wanted {DEFAULT_ENCODER}.")
    rows = [
        {
            "domain": kept.header.domains[kept.domain[index]],
            "material": kept.header.classes[kept.label[index]],
            **{name: kept.rows[name][index] for name in ("vis", "tac", "split", "object")},
        }
        for index in range(len(kept))
    ]
    return Features(vis=unit(kept.vis), tac=unit(kept.tac), rows=rows)


def features_of(pairs: Path) -> Features:
    """Return the embeddings of all images that `pairs/pairs.csv` lists."""
    table = pairs / "pairs.csv"
    if not table.exists():
        raise DataError(f"'{table}' is not there; make it with `python -m omnivat simulate`.")
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    vis = embedded([pairs / row["vis"] for row in rows])
    tac = embedded([pairs / row["tac"] for row in rows])
    return Features(vis=vis, tac=tac, rows=rows)


def unit(values: Array) -> Array:
    """Return vectors (N, D) of length 1."""
    wide = np.asarray(values, dtype=np.float32)
    return np.asarray(wide / np.linalg.norm(wide, axis=1, keepdims=True))


def embedded(files: list[Path]) -> Array:
    """Return the default encoder's embeddings of image files, each of unit length."""
    import torch
    from PIL import Image

    from omnivat.encoders.base import load_encoder

    encoder = load_encoder(DEFAULT_ENCODER)
    parts = []
    with torch.no_grad():
        for start in range(0, len(files), _BATCH):
            images = [Image.open(file).convert("RGB") for file in files[start : start + _BATCH]]
            parts.append(
                encoder.embed(torch.stack([encoder.preprocess(i) for i in images])).numpy()
            )
    return unit(np.concatenate(parts))


def print_probe(features: Features) -> None:
    """Print linear-probe accuracy from each domain to each, for VIS, TAC and both."""
    for name, values in (
        ("VIS + TAC", features.both),
        ("VIS", features.vis),
        ("TAC", features.tac),
    ):
        matrix = probe_matrix(
            values,
            materials=features.column("material"),
            domains=features.column("domain"),
            splits=features.column("split"),
        )
        _print_matrix(name, matrix)


def print_growth(features: Features) -> None:
    """Print what more objects to train on are worth within a domain, VIS and TAC together."""
    print("## Within a domain, by objects trained on (VIS + TAC)\n")
    print("| objects of each class | mean over domains, % |\n| ---: | ---: |")
    for count in (3, 7, 14, 28):
        shares = within_with(
            features.both,
            materials=features.column("material"),
            domains=features.column("domain"),
            splits=features.column("split"),
            objects=features.column("object"),
            count=count,
        )
        print(f"| {count} | {100 * np.mean([cell.share for cell in shares.values()]):.1f} |")
    print()


def print_other_splits(features: Features) -> None:
    """Print the accuracy within a domain where other runs of 12 objects are the test."""
    numbers = {
        pair.object: pair.number % len(plan)
        for domain in DOMAINS.values()
        for material in classes(domain)
        for plan in [planned(domain, material, pairs=OBJECTS)]
        for pair in plan
    }
    names = features.column("object")
    if set(names) != set(numbers):
        return  # a set of another size: its objects have other numbers
    number, both = np.array([numbers[str(name)] for name in names]), features.both
    materials, domains = features.column("material"), features.column("domain")
    print("## Within a domain, other objects as the test (VIS + TAC)\n")
    print("| objects, along the rotation | mean over domains, % |\n| --- | ---: |")
    for start in range(0, OBJECTS - TEST_OBJECTS + 1, 7):
        test = (number >= start) & (number < start + TEST_OBJECTS)
        shares = []
        for domain in dict.fromkeys(map(str, domains)):
            train, asked = (domains == domain) & ~test, (domains == domain) & test
            right = fitted(both[train], materials[train])(both[asked]) == materials[asked]
            shares.append(right.mean())
        print(f"| {start} to {start + TEST_OBJECTS - 1} | {100 * np.mean(shares):.1f} |")
    print()


def print_strengths(features: Features) -> None:
    """Print how strongly a probe should be held back, by what the training objects alone say."""
    both, train = features.both, features.column("split") == "train"
    domains = features.column("domain")
    print("## C of the probe, by cross-validation over training objects (VIS + TAC)\n")
    print("| C | mean over domains, % |\n| ---: | ---: |")
    for strength in (1e-3, 1e-2, 1e-1, 1.0, 10.0):
        shares = []
        for domain in dict.fromkeys(map(str, domains)):
            here = train & (domains == domain)
            found = cross_validated(
                both[here],
                materials=features.column("material")[here],
                objects=features.column("object")[here],
                strength=strength,
            )
            shares.append(found.share)
        print(f"| {strength:g} | {100 * np.mean(shares):.1f} |")
    print()


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


def print_examples(features: Features, folder: Path) -> None:
    """Print how near the embeddings of lossy example images are to those of the images themselves.

    Beside the cosine, whether a linear probe of all training pairs says the same of both.
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
    whole = features.both
    train = features.column("split") == "train"
    probe = fitted(whole[train], features.column("material")[train])
    before, after = probe(whole[own]), probe(np.concatenate([vis, tac], axis=1))
    print("## Example images, lossy, against the images that were embedded\n")
    print("| | images | least cosine | mean cosine |\n| --- | ---: | ---: | ---: |")
    for name, here, there in (("VIS", vis, features.vis[own]), ("TAC", tac, features.tac[own])):
        near = (here * there).sum(1)
        print(f"| {name} | {len(near)} | {near.min():.3f} | {near.mean():.3f} |")
    print(f"\nThe same material is predicted for {(before == after).sum()} of {len(own)} pairs.\n")


def _said(counts: Counter[str]) -> str:
    return ", ".join(f"{paper_name(name)} {count}" for name, count in counts.most_common())


def _sensor(domain: str) -> str:
    return DOMAINS[paper_name(domain)].sensor


if __name__ == "__main__":
    main()
