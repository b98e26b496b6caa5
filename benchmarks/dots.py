"""What the fill of printed dots finds and how near it comes to the same press drawn without dots.

    python -m benchmarks.dots [--presses 8] [--without DIR ...] [--out docs/benchmarks/dots.json]

Each press of new objects is drawn twice, with the sensor's dots and without. `--without` names
folders of real pictures without dots; only how many are changed is recorded. OpenCV's inpainting
stands beside the fill where opencv-python-headless is installed. Times are of one core's work,
median of all pictures.
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from benchmarks.measure import machine
from omnivat.cli.dots import images_of
from omnivat.data.dots import dotted, fill_dots, membrane
from omnivat.data.grid import find_grid
from omnivat.data.images import read_image
from omnivat.encoders import load_encoder
from omnivat.encoders.cache import embed_image
from omnivat.kit.files import write_json
from omnivat.kit.seeding import derive_seed
from omnivat.simulate.domains import SIMULATED
from omnivat.simulate.drawing import tactile
from omnivat.simulate.plan import classes, planned
from omnivat.simulate.sensors import Sensor
from omnivat.simulate.things import thing

NEW = 86_000  # number of the first object; no set has these
INKED = 15  # of 255: a pixel that the dots change by more belongs to a dot
SIDES = (224, 480, 1080)

Array = np.ndarray[Any, np.dtype[Any]]


def presses(name: str, count: int, side: int) -> Iterator[tuple[Array, Array]]:
    """Yield each press of a domain as drawn, and without dots."""
    domain = replace(SIMULATED[name], seed_base=NEW)
    for material in classes(domain):
        for pair in list(planned(domain, material, pairs=60))[:count]:
            made, stream = (
                thing(pair, seed=0),
                derive_seed(0, "pair", pair.domain, pair.material, pair.object),
            )
            sensors = [domain.sensor]
            if isinstance(domain.sensor, Sensor) and domain.sensor.markers:
                sensors.append(replace(domain.sensor, markers=None))
            drawn = [
                (255 * tactile(made, s, stream, size=side)).round().astype(np.uint8)
                for s in sensors
            ]
            yield drawn[0], drawn[-1]


def ways() -> dict[str, Callable[[Array, Array], Array]]:
    """Return other ways to fill the same holes: (picture, hole) -> picture."""

    def smooth(picture: Array, hole: Array) -> Array:
        result = picture.copy()
        result[hole] = np.clip(np.rint(membrane(picture, hole)[hole]), 0, 255)
        return result

    def inpainted(picture: Array, hole: Array, kind: int) -> Array:
        return np.asarray(cv2.inpaint(picture, hole.astype(np.uint8), 3, kind))

    found: dict[str, Callable[[Array, Array], Array]] = {"without grain": smooth}
    try:
        import cv2
    except ImportError:
        return found
    for name, kind in (
        ("OpenCV, Telea", cv2.INPAINT_TELEA),
        ("OpenCV, Navier-Stokes", cv2.INPAINT_NS),
    ):
        found[name] = partial(inpainted, kind=kind)
    return found


def of_domain(name: str, count: int) -> dict[str, Any]:
    """Return what is found and how near the filled pictures come to the truth."""
    encoder = load_encoder("efficientnet-lite0")

    def nearness(first: Array, other: Array) -> float:
        a, b = (embed_image(encoder, Image.fromarray(picture)) for picture in (first, other))
        return float(a @ b / np.linalg.norm(a) / np.linalg.norm(b))

    dotted_, found, plain, false = 0, 0, 0, 0
    rows: dict[str, list[float]] = {}
    for marked, bare in presses(name, count, 224):
        change = np.abs(marked.astype(float) - bare).max(2)
        filled, dots = fill_dots(marked)
        inside = change > INKED
        if not inside.any():
            plain, false = plain + 1, false + (dots is not None)
            continue
        plain, false = plain + 1, false + (fill_dots(bare)[1] is not None)
        dotted_, found = dotted_ + 1, found + (dots is not None)
        if dots is None:
            continue
        changed = (filled != marked).any(2)
        grid = find_grid(marked.max(2))
        assert grid is not None
        hole = dotted(marked.max(2), grid)[0]
        figures = {
            "share of the dots' pixels filled": changed[inside].mean(),
            "share of the other pixels changed": changed[~inside].mean(),
            "error in dots, as is": change[inside].mean(),
            "error in dots, filled": np.abs(filled.astype(float) - bare)[inside].mean(),
            "cosine, as is": nearness(marked, bare),
            "cosine, filled": nearness(filled, bare),
        }
        for way, fill in ways().items():
            other = fill(marked, hole)
            figures[f"error in dots, {way}"] = np.abs(other.astype(float) - bare)[inside].mean()
            figures[f"cosine, {way}"] = nearness(other, bare)
        for key, value in figures.items():
            rows.setdefault(key, []).append(float(value))
    means = {
        key: [round(statistics.fmean(v), 4), round(statistics.pstdev(v), 4)]
        for key, v in rows.items()
    }
    return {
        "with dots": dotted_, "grid found": found, "without dots": plain, "filled without dots": false,
        "mean and deviation": means,
    }  # fmt: skip


def times(side: int) -> dict[str, float]:
    """Return the milliseconds of a picture with dots and of one without, of `side` pixels."""
    taken: dict[str, list[float]] = {"with dots": [], "without dots": []}
    for marked, bare in presses("TAG", 2, side):
        for kind, picture in zip(taken, (marked, bare), strict=True):
            for _ in range(3):
                began = time.thread_time()
                fill_dots(picture)
                taken[kind].append(1000 * (time.thread_time() - began))
    return {kind: round(statistics.median(all_), 2) for kind, all_ in taken.items()}


def changed_in(folder: Path) -> dict[str, int]:
    """Return how many pictures a folder has, and how many of them the fill changes."""
    pictures = [np.asarray(read_image(file)) for file in images_of(folder)]
    return {
        "pictures": len(pictures),
        "changed": sum(fill_dots(picture)[1] is not None for picture in pictures),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and write the record."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--presses", type=int, default=8, help="of each class of each domain")
    parser.add_argument(
        "--without", type=Path, nargs="*", default=(), help="folders of real pictures without dots"
    )
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks/dots.json"))
    options = parser.parse_args(arguments)
    record: dict[str, Any] = {
        "machine": machine(),
        "presses of a class": options.presses,
        "domains": {},
    }
    for name in SIMULATED:
        record["domains"][name] = of_domain(name, options.presses)
        print(name, json.dumps(record["domains"][name]), flush=True)
    record["real, without dots"] = {folder.name: changed_in(folder) for folder in options.without}
    record["ms"] = {str(side): times(side) for side in SIDES}
    print(json.dumps({key: record[key] for key in ("real, without dots", "ms")}))
    write_json(options.out, record)


if __name__ == "__main__":
    main()
