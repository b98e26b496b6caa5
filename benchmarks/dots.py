"""What the fill of printed dots finds, how near it comes to the same press without dots, and what it
changes by mistake.

    python -m benchmarks.dots [--presses 8] [--without DIR ...] [--out docs/benchmarks/dots.json]
    python -m benchmarks.dots --picture docs/dots.webp      a press by every sensor, before and after

Each press of new objects is drawn twice, with the sensor's dots and without. Pictures without dots
are these presses, odd pictures (`_dots_odd`) and folders of real ones (`--without`), of which only
the counts are recorded. OpenCV's inpainting stands beside the fill where opencv-python-headless is
installed. Brackets: 95 % intervals, over presses or of a share (Wilson). Times are of one core's
work, the quickest of twenty runs, median of the pictures.
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from scipy.ndimage import label

from benchmarks._dots_odd import ODD
from benchmarks._dots_odd import picture as as_picture
from benchmarks.measure import machine
from omnivat.cli.dots import images_of
from omnivat.data.dots import dotted, fill_dots, membrane
from omnivat.data.grid import find_grid
from omnivat.data.images import read_image
from omnivat.encoders import load_encoder
from omnivat.encoders.cache import embed_image
from omnivat.kit.files import write_json
from omnivat.kit.seeding import derive_seed
from omnivat.measure.unseen import wilson
from omnivat.simulate.domains import SIMULATED
from omnivat.simulate.drawing import tactile
from omnivat.simulate.plan import classes, planned
from omnivat.simulate.sensors import Sensor
from omnivat.simulate.things import thing
from omnivat.study.shift.measure import interval

NEW = 86_000  # number of the first object; no set has these
INKED = 15  # of 255: a pixel that the dots change by more belongs to a dot
SMALLEST_DOT = 12  # pixels: dots cut off by the rim are smaller
SIDES = (224, 480, 1080)

Array = np.ndarray[Any, np.dtype[Any]]


def presses(
    name: str, count: int, side: int, *, bare: bool = False
) -> Iterator[tuple[Array, Array]]:
    """Yield each press of a domain as drawn, and without dots; `bare`: without dots twice."""
    domain = replace(SIMULATED[name], seed_base=NEW)
    sensors = [domain.sensor]
    if isinstance(domain.sensor, Sensor) and domain.sensor.markers:
        sensors.append(replace(domain.sensor, markers=None))
    for material in classes(domain):
        for pair in list(planned(domain, material, pairs=60))[:count]:
            made = thing(pair, seed=0)
            stream = derive_seed(0, "pair", pair.domain, pair.material, pair.object)
            drawn = [
                (255 * tactile(made, sensor, stream, size=side)).round().astype(np.uint8)
                for sensor in (sensors[-1:] if bare else sensors)
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

    gels, dots_there, dots_filled, bare_changed = [], 0, 0, []
    rows: dict[str, list[float]] = {}
    for marked, bare in presses(name, count, 224):
        change = np.abs(marked.astype(float) - bare).max(2)
        after, dots = fill_dots(marked)
        inside = change > INKED
        bare_changed.append(fill_dots(bare)[1] is not None)
        if not inside.any():
            continue
        gels.append(dots is not None)
        changed = (after != marked).any(2)
        names, number = label(inside)
        sizes = np.bincount(names.ravel(), minlength=number + 1)[1:]
        covered = np.bincount(names[changed], minlength=number + 1)[1:]
        whole = sizes >= SMALLEST_DOT
        dots_there += int(whole.sum())
        dots_filled += int((covered[whole] > sizes[whole] / 2).sum())
        if dots is None:
            continue
        left = np.abs(after.astype(float) - bare)
        figures = {
            "share of the other pixels changed": changed[~inside].mean(),
            "error in dots, as is": np.abs(marked.astype(float) - bare)[inside].mean(),
            "error in dots, filled": left[inside].mean(),
            "error outside, as is": np.abs(marked.astype(float) - bare)[~inside].mean(),
            "error outside, filled": left[~inside].mean(),
            "cosine, as is": nearness(marked, bare),
            "cosine, filled": nearness(after, bare),
        }
        grid = find_grid(marked.max(2))
        assert grid is not None
        hole = dotted(marked.max(2), grid)[0]
        for way, fill in ways().items():
            other = fill(marked, hole)
            figures[f"error in dots, {way}"] = np.abs(other.astype(float) - bare)[inside].mean()
            figures[f"cosine, {way}"] = nearness(other, bare)
        for key, value in figures.items():
            rows.setdefault(key, []).append(float(value))
    found: dict[str, Any] = {"changed without dots": share(sum(bare_changed), len(bare_changed))}
    if gels:
        found["presses with dots"] = share(sum(gels), len(gels))
        found["dots filled"] = share(dots_filled, dots_there)
    for key, values in rows.items():
        low, high = interval(np.array(values), np.arange(len(values)))
        found[key] = [round(one, 4) for one in (statistics.fmean(values), low, high)]
    return found


def share(count: int, total: int) -> list[float]:
    """Return a count, of how many, and the 95 % interval of the share."""
    low, high = wilson(count, total)
    return [count, total, round(low, 4), round(high, 4)]


def changed(pictures: Iterable[Array]) -> list[float]:
    """Return how many of some pictures without dots the fill changes."""
    results = [fill_dots(one)[1] is not None for one in pictures]
    return share(sum(results), len(results))


def times(side: int) -> dict[str, float]:
    """Return the milliseconds of a picture with dots and of one without, of `side` pixels."""
    taken: dict[str, list[float]] = {"with dots": [], "without dots": []}
    for marked, bare in islice(presses("TAG", 1, side), 3):
        for kind, picture in zip(taken, (marked, bare), strict=True):
            runs = []
            for _ in range(20):
                began = time.thread_time()
                fill_dots(picture)
                runs.append(1000 * (time.thread_time() - began))
            taken[kind].append(min(runs))
    return {kind: round(statistics.median(all_), 2) for kind, all_ in taken.items()}


def false_fills(without: Sequence[Path], count: int) -> dict[str, Any]:
    """Return what is changed in pictures without dots, of every size."""
    found: dict[str, Any] = {}
    for side in SIDES:
        some = 1 if side == max(SIDES) else count
        bare = (bare for name in SIMULATED for _, bare in presses(name, some, side, bare=True))
        found[f"simulated gels, {side} pixels"] = changed(bare)
        odd = (as_picture(make(side, seed)) for make in ODD.values() for seed in range(10 * some))
        found[f"odd pictures, {side} pixels"] = changed(odd)
    for folder in without:
        real = (np.asarray(read_image(file)) for file in images_of(folder))
        found[f"real: {folder.name}"] = changed(real)
        print(list(found.items())[-1:], flush=True)
    found["all"] = share(*(int(sum(one[k] for one in found.values())) for k in (0, 1)))
    return found


def sheet(side: int = 224) -> Image.Image:
    """Return a press by every sensor: as imaged, filled, and drawn without dots. Of gels some of
    which have no dots, one with dots is shown.
    """
    columns = []
    for name in SIMULATED:
        drawn = list(presses(name, 1, side))
        marked, bare = next((p for p in drawn if fill_dots(p[0])[1] is not None), drawn[0])
        columns.append(np.concatenate([marked, fill_dots(marked)[0], bare]))
    return Image.fromarray(np.concatenate(columns, 1))


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
    parser.add_argument("--picture", type=Path, help="write only a picture of presses, as WebP")
    options = parser.parse_args(arguments)
    if options.picture:
        sheet().save(options.picture, "WEBP", quality=85)
        return
    record: dict[str, Any] = {
        "machine": machine(),
        "presses of a class": options.presses,
        "domains": {},
    }
    for name in SIMULATED:
        record["domains"][name] = of_domain(name, options.presses)
        print(name, json.dumps(record["domains"][name]), flush=True)
    record["changed without dots"] = false_fills(options.without, max(1, options.presses // 4))
    record["ms"] = {str(side): times(side) for side in SIDES}
    print(json.dumps({key: record[key] for key in ("changed without dots", "ms")}))
    write_json(options.out, record)


if __name__ == "__main__":
    main()
