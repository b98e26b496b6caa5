"""Labelled real pairs, predicted by probes trained on all domains of a set and by a trained head.

The folder holds `labels.csv` with the columns folder, vis, tac and material; images are at
<folder>/<vis> and <folder>/<tac>. Pairs of other materials than the five are left out.
"""

import csv
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.simulated_features import Array, Features, Names, encoded, unit
from benchmarks.simulated_probe import FUSIONS, READINGS, read_all
from omnivat.data.domains import paper_name
from omnivat.data.materials import MATERIALS, class_key
from omnivat.kit.errors import DataError

HEAD = Path("examples/head")
_Z = 1.96


@dataclass(frozen=True, slots=True, kw_only=True)
class Real:
    """Labelled real pairs: embeddings (N, D) of any length, a class name and a sensor each."""

    vis: Array
    tac: Array
    materials: Names
    sensors: Names


def real_pairs(folder: Path) -> Real:
    """Return the labelled pairs of a folder. Raises DataError if there are none."""
    table = folder / "labels.csv"
    if not table.is_file():
        raise DataError(f"'{table}' is not there; wanted columns folder, vis, tac, material.")
    with table.open(encoding="utf-8", newline="") as file:
        rows = [r for r in csv.DictReader(file) if class_key(r["material"]) in MATERIALS]
    if not rows:
        raise DataError(f"'{table}' names no pair of {', '.join(MATERIALS)}.")
    files = {name: [folder / row.get("folder", "") / row[name] for row in rows] for name in ("vis", "tac")}
    return Real(
        vis=encoded(files["vis"]),
        tac=encoded(files["tac"]),
        materials=np.array([class_key(row["material"]) for row in rows]),
        sensors=np.array([row.get("sensor", "") for row in rows]),
    )


def print_real(features: Features, real: Real, head: Path = HEAD) -> None:
    """Print the accuracy of the probes and the head, and the position of real touches."""
    count = Counter(map(str, real.materials))
    print(f"## Real pairs: {len(real.materials)} ({_counts(count)})\n")
    print(
        f"Chance is {100 / len(MATERIALS):.0f} %; always naming the largest class is right in "
        f"{100 * max(count.values()) / len(real.materials):.0f} %.\n"
    )
    print("| prediction | right | % (95 % Wilson interval) |\n| --- | ---: | ---: |")
    for name, predicted in predictions(features, real).items():
        _print_row(f"probe, {FUSIONS.get(name, name)}", predicted, real.materials)
    for name, predicted in _head_predictions(head, features, real).items():
        _print_row(f"default head, {name}", predicted, real.materials)
    print()
    _print_neighbours(features, real)


def predictions(features: Features, real: Real) -> dict[str, Names]:
    """Return the predictions of probes trained on the whole set: reading -> (N,) class names."""
    known = features.column("material")
    train = np.arange(len(known) + len(real.materials)) < len(known)
    found = read_all(
        np.concatenate([features.vis, unit(real.vis)]),
        np.concatenate([features.tac, unit(real.tac)]),
        train,
        np.concatenate([known, real.materials]),
    )
    return {name: found[name][~train] for name in READINGS}


def _head_predictions(folder: Path, features: Features, real: Real) -> dict[str, Names]:
    """Return the head's predictions, or nothing if it is missing or needs other embeddings."""
    import torch

    from omnivat.head.checkpoint import load_head
    from omnivat.head.predict import PRECISION, predict_embeddings

    if not folder.is_dir():
        return {}
    head = load_head(folder, dtype=PRECISION)
    if head.settings.input_width != features.vis.shape[1]:
        return {}
    vis, tac = (torch.from_numpy(values).to(PRECISION) for values in (real.vis, real.tac))
    given = {"photo only": (vis, None), "touch only": (None, tac), "both": (vis, tac)}
    return {
        name: np.array([row["prediction"] for row in predict_embeddings(head, *pair)]) for name, pair in given.items()
    }


def _print_row(name: str, predicted: Names, materials: Names) -> None:
    right, of = int((predicted == materials).sum()), len(materials)
    low, high = wilson(right, of)
    share = f"{100 * right / of:.0f} ({100 * low:.0f} to {100 * high:.0f})"
    print(f"| {name} | {right} of {of} | {share} |")


def wilson(right: int, of: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share."""
    share, spread = right / of, _Z**2 / of
    middle = (share + spread / 2) / (1 + spread)
    half = _Z * np.sqrt(share * (1 - share) / of + spread / (4 * of)) / (1 + spread)
    return float(middle - half), float(middle + half)


def _print_neighbours(features: Features, real: Real) -> None:
    domains = features.column("domain")
    nearest = np.argsort(-(unit(real.tac) @ features.tac.T), axis=1)[:, :5]
    print("## Real tactile images: simulated domains of their five nearest neighbours\n")
    print("| sensor | images | nearest | five nearest |\n| --- | ---: | --- | --- |")
    for sensor in dict.fromkeys(map(str, real.sensors)):
        mine = nearest[real.sensors == sensor]
        first, five = (Counter(map(str, domains[mine[:, 0]])), Counter(map(str, domains[mine.ravel()])))
        print(f"| {sensor or 'not stated'} | {len(mine)} | {_counts(first)} | {_counts(five)} |")
    print()


def _counts(counts: Counter[str]) -> str:
    return ", ".join(f"{paper_name(name)} {count}" for name, count in counts.most_common())
