"""Maps of 2,000 points: our UMAP against umap-learn and PCA, and a chain of maps over p.

    python -m benchmarks.projection [--points 2000] [--width 512] [--runs 5] [--threads 1] [--out
    FILE] python -m benchmarks.projection --large

Each method runs in a separate process, so that its first call includes compilation and warm-up. All
methods use the same points for quality. One thread by default: with more, waiting threads count as
CPU time.
"""

import argparse
import json
import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from benchmarks.measure import as_dict, machine, timed
from omnivat.kit.tables import load
from omnivat.maps.projection import PROJECTIONS
from omnivat.maps.projection.quality import drift, quality

CHAIN_STOPS = 11
MANY = 20_000  # points of `--large`


def made_points(count: int, width: int) -> Tensor:
    """Return rows with the shape of visual-tactile embeddings: (count, width), unit length.

    Each modality, domain and class has a direction; the rows of an object lie on a curved
    two-dimensional sheet, with a little noise.
    """
    rng = np.random.default_rng(0)
    modality = np.arange(count) % 2
    domain, kind = rng.integers(0, 8, count), rng.integers(0, 5, count)
    sheet = rng.uniform(-2, 2, (count, 2))
    waves = np.cos(sheet @ rng.normal(size=(2, 24)) + rng.uniform(0, 6, 24))
    directions = [rng.normal(size=(n, width)) for n in (2, 8, 5, 24)]
    rows = (
        1.5 * directions[0][modality]
        + directions[1][domain]
        + 0.8 * directions[2][kind]
        + 0.35 * waves @ directions[3]
        + 0.1 * rng.normal(size=(count, width))
    )
    return torch.nn.functional.normalize(torch.from_numpy(rows).float())


def method_report(name: str, points: Tensor, runs: int) -> dict[str, Any]:
    """Time a method's first call in this process and later calls, and measure its map."""
    begun = time.process_time()
    project: Callable[[Tensor], Tensor] = load(PROJECTIONS, name, kind="projection")
    if name == "umap-learn":
        import umap  # noqa: F401  # the import is not part of the first call
    imported = time.process_time() - begun
    first = timed(lambda: project(points), 1)
    flat = project(points)
    score = quality(points, flat, rows=len(points))
    return {
        "method": name,
        "import_cpu": imported,
        "first": as_dict(first),
        "again": as_dict(timed(lambda: project(points), runs)),
        "trustworthiness": score.trustworthiness,
        "recall_at_15": score.recall,
    }


def large_report() -> dict[str, Any]:
    """Time one UMAP map of MANY points of width 64, and measure it on 1,000 of them."""
    from omnivat.maps.projection import torch_umap

    points = made_points(MANY, 64)
    torch_umap.project(points[:500])  # warm
    begun = time.process_time()
    flat = torch_umap.project(points)
    cpu = time.process_time() - begun
    score = quality(points, flat)
    return {
        "points": MANY,
        "cpu": cpu,
        "trustworthiness": score.trustworthiness,
        "recall_at_15": score.recall,
    }


def chain_report(points: Tensor) -> list[dict[str, Any]]:
    """One map for each of 11 orders of ReLU(Re, Im): independent, and as a chain."""
    from omnivat.fractional import coefficients, synthesise
    from omnivat.maps.projection import torch_umap
    from omnivat.maps.projection.torch_umap import chain

    kept = coefficients(points)
    stops = []
    for order in torch.linspace(0, 1, CHAIN_STOPS).tolist():
        turned = synthesise(kept, order)
        stops.append(torch.cat([turned.real.relu(), turned.imag.relu()], dim=1))
    torch_umap.project(points)  # both are timed warm
    found = []
    ways: dict[str, Callable[[], list[Tensor]]] = {
        "apart, one seed": lambda: [torch_umap.project(rows) for rows in stops],
        "chain": lambda: list(chain(stops)),
    }
    for name, maps in ways.items():
        begun = time.process_time()
        flats = maps()
        cpu = time.process_time() - begun
        scores = [quality(x, y, rows=len(x)) for x, y in zip(stops, flats, strict=True)]
        found.append(
            {
                "maps": name,
                "cpu": cpu,
                "drift": float(np.mean([drift(a, b) for a, b in pairwise(flats)])),
                "trustworthiness": float(np.mean([score.trustworthiness for score in scores])),
                "recall_at_15": float(np.mean([score.recall for score in scores])),
            }
        )
    return found


def in_own_process(name: str, arguments: argparse.Namespace) -> dict[str, Any]:
    """Run one method in a fresh interpreter and return its report."""
    command = [sys.executable, "-m", "benchmarks.projection", "--only", name]
    for option in ("points", "width", "runs", "threads"):
        command += [f"--{option}", str(getattr(arguments, option))]
    limits = dict.fromkeys(("OMP_NUM_THREADS", "NUMBA_NUM_THREADS"), str(arguments.threads))
    done = subprocess.run(
        command, check=True, capture_output=True, text=True, env={**os.environ, **limits}
    )
    report: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return report


def show(report: dict[str, Any]) -> None:
    """Print both tables."""
    print(json.dumps(report["machine"]))
    print("| method | first call, CPU s | again, CPU s (lowest to highest) | trust | recall@15 |")
    print("| --- | --- | --- | --- | --- |")
    for row in report["methods"]:
        again = row["again"]
        print(
            f"| {row['method']} | {row['first']['cpu']:.2f} | {again['cpu']:.2f} "
            f"({again['cpu_low']:.2f} to {again['cpu_high']:.2f}) "
            f"| {row['trustworthiness']:.4f} | {row['recall_at_15']:.3f} |"
        )
    print("\n| 11 orders | CPU s | drift | trust | recall@15 |\n| --- | --- | --- | --- | --- |")
    for row in report["chain"]:
        print(
            f"| {row['maps']} | {row['cpu']:.2f} | {row['drift']:.3f} "
            f"| {row['trustworthiness']:.4f} | {row['recall_at_15']:.3f} |"
        )


def main() -> None:
    """Read the arguments, measure, print, and write the JSON if requested."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=2000)
    parser.add_argument("--width", type=int, default=512)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--large", action="store_true", help=f"only UMAP of {MANY:,} points")
    parser.add_argument("--only", choices=list(PROJECTIONS), help=argparse.SUPPRESS)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)
    if arguments.large:
        print(json.dumps({"machine": machine(), "large": large_report()}, indent=2))
        return
    points = made_points(arguments.points, arguments.width)
    if arguments.only:
        warnings.simplefilter("ignore")  # umap-learn warns that a seed means one thread
        print(json.dumps(method_report(arguments.only, points, arguments.runs)))
        return
    report = {
        "machine": machine(),
        "points": arguments.points,
        "width": arguments.width,
        "methods": [in_own_process(name, arguments) for name in PROJECTIONS],
        "chain": chain_report(points),
    }
    show(report)
    if arguments.out:
        arguments.out.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
