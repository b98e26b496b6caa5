"""Embed 10,000 generated JPEGs: memory held, killed half-way, resumed. `python -m benchmarks.embed_scale`

The parent writes the images (640 x 480, all different), starts the embedding in a process of its
own, kills it without warning when half of the part files are there, starts it again, and watches
the memory of both. It fails when the peak passes 2 GB or a pair is missing. Linux only: it reads
the peak from /proc.
"""

import argparse
import json
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from benchmarks.measure import machine

LIMIT_MB = 2000
ENCODER = "efficientnet-lite0"


def main() -> None:
    """Run the measurement and print it as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--images", type=int, default=10_000)
    parser.add_argument("--child", nargs=2, metavar=("FOLDER", "OUT"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        embed(*map(Path, options.child))
        return
    with tempfile.TemporaryDirectory() as folder:
        print(json.dumps(measured(Path(folder), options.images), indent=2))


def measured(folder: Path, images: int) -> dict[str, Any]:
    """Embed, kill, resume; return memory, time and counts."""
    images_folder, out = folder / "images", folder / "set.safetensors"
    write_images(images_folder, images)
    first = watched(images_folder, out, kill_at=images // 2 // 128 // 2)
    second = watched(images_folder, out, kill_at=None)
    report = json.loads(second.pop("said"))
    first.pop("said")
    peak = max(first["peak_mb"], second["peak_mb"])
    if peak > LIMIT_MB or report["embedded"] != images // 2 or report["resumed"] == 0:
        raise SystemExit(f"Not as promised: peak {peak} MB, {report}.")
    return {
        "images": images,
        "pairs": images // 2,
        "killed": first,
        "resumed": second | report,
        "machine": machine(),
    }


def write_images(folder: Path, count: int) -> None:
    """Write `count` different JPEGs in pairs: enlarged noise, 640 x 480."""
    folder.mkdir()
    random = np.random.default_rng(0)
    for number in range(count):
        small = Image.fromarray(random.integers(0, 256, (30, 40, 3), dtype=np.uint8))
        name = f"{number // 2:06}_{('vis', 'tac')[number % 2]}.jpg"
        small.resize((640, 480), Image.Resampling.BILINEAR).save(folder / name, quality=85)


def watched(images: Path, out: Path, kill_at: int | None) -> dict[str, Any]:
    """Run the embedding in another process; kill it when that many part files are there."""
    command = [sys.executable, "-m", "benchmarks.embed_scale", "--child", str(images), str(out)]
    began, peak = time.perf_counter(), 0.0
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    parts = out.with_name(out.name + ".parts")
    while process.poll() is None:
        peak = max(peak, peak_mb(process.pid))
        if kill_at is not None and len(list(parts.glob("part-*.safetensors"))) >= kill_at:
            process.send_signal(signal.SIGKILL)
            break
        time.sleep(0.2)
    said = process.communicate()[0]
    seconds = round(time.perf_counter() - began, 1)
    return {"peak_mb": round(peak), "wall_s": seconds, "exit": process.returncode, "said": said}


def peak_mb(pid: int) -> float:
    """Return the most memory the process has held so far, in MB; 0 when it has ended."""
    try:
        text = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0.0
    found = [line for line in text.splitlines() if line.startswith("VmHWM")]
    return int(found[0].split()[1]) / 1000 if found else 0.0


def embed(images: Path, out: Path) -> None:
    """Embed the pairs in `images`, without mirrored copies, and print the counts."""
    from omnivat.data.pairs import Pair, PairSet
    from omnivat.embed import embed_pairs

    pairs = [
        Pair(
            vis=file,
            tac=file.with_name(file.name.replace("_vis", "_tac")),
            domain="generated",
            material="none",
        )
        for file in sorted(images.glob("*_vis.jpg"))
    ]
    report = embed_pairs(PairSet(pairs=tuple(pairs)), ENCODER, out, flips=False)
    fresh = len(pairs) - report.resumed
    rate = round(2 * fresh / report.seconds, 1)
    counts = {"embedded": report.embedded, "resumed": report.resumed, "images_per_s": rate}
    print(json.dumps(counts))


if __name__ == "__main__":
    main()
