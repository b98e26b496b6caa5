"""Time an image against the error of its embedding, for each way to run an encoder.

    python -m benchmarks.encoders [--rounds 5] [--pictures 16] [--batches 4,16] [--out docs/benchmarks]

With --out it writes encoders.json, encoders.md and, with matplotlib installed, encoders.png. All
ways run on one thread, like the embedding engine's workers, and alternate, so that other load
affects all of them. On a shared machine, compare CPU time. The error is 1 - cosine to fp32, image
by image, over generated pictures.

bf16 is included if the CPU has instructions for it (`omnivat.encoders.running.cpu_has_bf16`), ONNX
Runtime if `onnx`, `onnxscript` and `onnxruntime` are installed. EfficientNet-Lite0 has its
published weights. CLIP's towers have random weights of the published sizes: their times are valid,
their errors approximate.
"""

import argparse
import json
import logging
import statistics
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from benchmarks._encoder_ways import Run, networks, pictures
from benchmarks.encoders_plot import page, plot
from benchmarks.measure import machine
from omnivat.encoders.running import cpu_has_bf16


def main() -> None:
    """Measure every way, print the page of figures, and write it if requested."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="folder for the three files")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--pictures", type=int, default=16)
    parser.add_argument("--batches", default="4,16")
    options = parser.parse_args()
    torch.set_num_threads(1)
    logging.disable(logging.WARNING)
    warnings.simplefilter("ignore")
    images, batches = pictures(options.pictures, seed=0), map(int, options.batches.split(","))
    rows = []
    with tempfile.TemporaryDirectory() as folder, torch.inference_mode():
        for network, ways in networks(Path(folder), tuple(batches)):
            rows += measured(network, ways, images, options.rounds)
    place = machine() | {"bf16": cpu_has_bf16(), "cpu": cpu_name()}
    found = {
        "machine": place,
        "rounds": options.rounds,
        "pictures": len(images),
        "batches": options.batches,
        "rows": rows,
    }
    print(page(found))
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        text = json.dumps(found, indent=2) + "\n"
        (options.out / "encoders.json").write_text(text, encoding="utf-8")
        (options.out / "encoders.md").write_text(page(found), encoding="utf-8")
        plot(rows, options.out / "encoders.png")


def cpu_name() -> str:
    """Return the name of the processor."""
    return str(torch.cpu.get_capabilities().get("cpu_name", "unknown"))


def measured(network: str, ways: dict[str, Run], images: Tensor, rounds: int) -> list[dict[str, Any]]:
    """Return a row for each way: milliseconds for each image, and error against the first way."""
    embedded = {name: way(images) for name, way in ways.items()}  # also warms up
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    for _ in range(rounds):
        for name, way in ways.items():
            times[name].append(timed(way, images))
    reference = next(iter(embedded.values()))
    base = statistics.median(cpu for cpu, _ in times[next(iter(ways))])
    rows = []
    for name in ways:
        row = {"network": network, "way": name, **spread(times[name])}
        row["speed"] = round(base / statistics.median(cpu for cpu, _ in times[name]), 2)
        rows.append(row | error(embedded[name], reference))
    return rows


def timed(way: Run, images: Tensor) -> tuple[float, float]:
    """Return CPU and wall milliseconds for each image."""
    cpu, wall = time.process_time(), time.perf_counter()
    way(images)
    return (1e3 * (time.process_time() - cpu) / len(images), 1e3 * (time.perf_counter() - wall) / len(images))


def spread(times: list[tuple[float, float]]) -> dict[str, float]:
    """Return median, lowest and highest of both clocks."""
    found = {}
    for name, values in zip(("cpu", "wall"), zip(*times, strict=True), strict=True):
        found[f"{name}_ms"] = round(statistics.median(values), 2)
        found[f"{name}_low"], found[f"{name}_high"] = round(min(values), 2), round(max(values), 2)
    return found


def error(embedded: Tensor, reference: Tensor) -> dict[str, Any]:
    """Return 1 - cosine to the reference, of the median picture and the worst, and if bits agree."""
    away = 1 - torch.cosine_similarity(embedded.double(), reference.double())
    return {
        "error": max(away.median().item(), 0.0),
        "error_worst": max(away.max().item(), 0.0),
        "same_bits": torch.equal(embedded, reference),
    }


if __name__ == "__main__":
    main()
