"""Embed 10,000 generated JPEGs: peak memory, and identical bytes after a kill and resume.

    python -m benchmarks.embed_scale [--images 10000]

Writes the images (640 x 480, all different, and one that cannot be read), then runs
`python -m omnivat embed` on them in separate processes:

1. without interruption;
2. again to another file, killed without warning (SIGKILL) when half of the part files are there;
3. the same command again, which resumes from the parts.

It fails if a process uses more than 2 GB, if a pair is missing or embedded again, or if the two
files differ. Linux only: memory is read from /proc.

    python -m benchmarks.embed_scale --rate 200

Without a process of its own: reading, decoding and encoding that many JPEGs beside the encoder
alone on their tensors, in turns; prints the shares of processor time and of the clock.
"""

import argparse
import json
import signal
import subprocess
import sys
import tempfile
import time
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from benchmarks.measure import machine
from omnivat.data.store import load_embeddings
from omnivat.encoders.embed.job import CHUNK

LIMIT_MB = 2000
MATERIALS = ("wood", "steel", "plastic", "ceramic", "glass")


def main() -> None:
    """Run the measurement and print it as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--images", type=int, default=10_000)
    parser.add_argument(
        "--rate", type=int, help="only the share of the encoder, of this many images"
    )
    options = parser.parse_args()
    if options.rate:
        with tempfile.TemporaryDirectory() as folder:
            print(json.dumps(rate(Path(folder), options.rate), indent=2))
        return
    if options.images < 8 * CHUNK:
        parser.error(f"--images must be {8 * CHUNK} or more, or there is no half-way")
    with tempfile.TemporaryDirectory() as folder:
        found = measured(Path(folder), options.images)
    print(json.dumps(found, indent=2))


def measured(folder: Path, count: int) -> dict[str, Any]:
    """Embed whole; embed, kill and resume; compare. Return memory, time and counts."""
    images, whole, broken = folder / "images", folder / "whole", folder / "resumed"
    write_images(images, count)
    runs = {"whole": watched(images, whole / "set.safetensors", stop_at=None)}
    out, pairs = broken / "set.safetensors", count // 2
    runs["killed"] = watched(images, out, stop_at=pairs // CHUNK // 2)
    kept = len(parts_of(out))
    if out.exists() or not kept:
        raise SystemExit("The kill came too late or too early to prove anything.")
    runs["resumed"] = watched(images, out, stop_at=None)
    require(
        runs["resumed"]["said"],
        f"{pairs - 1} pairs embedded, {kept * CHUNK} of them by an earlier run",
    )
    embedded = len(load_embeddings(out))
    same = [digest(file) == digest(broken / file.name) for file in sorted(whole.iterdir())]
    peak = max(run["peak_mb"] for run in runs.values())
    if peak > LIMIT_MB or embedded != pairs - 1 or len(same) != 2 or not all(same):
        raise SystemExit(f"Not as promised: peak {peak} MB, {embedded} of {pairs}, same {same}.")
    return {
        "images": count,
        "pairs": pairs,
        "embedded": embedded,
        "kept_by_the_killed_run": kept * CHUNK,
        "images_per_s": round(count / runs["whole"]["wall_s"], 1),
        "cpu_ms_an_image": round(1e3 * runs["whole"]["cpu_s"] / count, 1),
        "file_mb": round(out.stat().st_size / 1e6, 1),
        "digest": digest(whole / "set.safetensors"),
        "runs": runs,
        "machine": machine(),
    }


def rate(folder: Path, count: int) -> dict[str, Any]:
    """Time whole pairs and the encoder alone in turns, a chunk of pairs at a time, on one
    thread.
    """
    from omnivat.data.images import read_image
    from omnivat.data.pairs import Pair
    from omnivat.encoders.embed.job import Job, embed_one
    from omnivat.kit.threads import pin_thread

    pin_thread()
    write_images(folder, count + 2)  # the last one cannot be read
    files = sorted(folder.rglob("*.jpg"))[:-2]
    pairs = [
        Pair(vis=a, tac=b, domain="", material="")
        for b, a in zip(files[::2], files[1::2], strict=True)
    ]
    found: dict[str, Any] = {"images": len(files), "machine": machine()}
    for flips in (True, False):
        job = Job(encoder="efficientnet-lite0", flips=flips)
        encoder = job.load()
        spent = np.zeros((2, 2))  # whole and encoder; processor and clock
        embed_one(encoder, job, pairs[0])  # warm
        for pair in pairs:
            began = np.array((time.process_time(), time.perf_counter()))
            embed_one(encoder, job, pair)
            spent[0] += (time.process_time(), time.perf_counter()) - began
            ready = [
                encoder.preprocess(read_image(file))
                for file in (pair.vis, pair.tac)
                for _ in job.views
            ]
            began = np.array((time.process_time(), time.perf_counter()))
            for pixels in ready:
                encoder.embed(pixels[None])
            spent[1] += (time.process_time(), time.perf_counter()) - began
        shares = spent[1] / spent[0]
        found["with mirrored images" if flips else "without"] = {
            "ms_an_image": round(1e3 * spent[0, 0] / len(files), 2),
            "of_them_the_encoder": round(1e3 * spent[1, 0] / len(files), 2),
            "share_of_processor": round(float(shares[0]), 3),
            "share_of_clock": round(float(shares[1]), 3),
        }
    return found


def require(said: str, sentence: str) -> None:
    """Raise an error for an unexpected run."""
    if sentence not in said:
        raise SystemExit(f"The command said '{said}', not '{sentence}'.")


def digest(file: Path) -> str:
    """Return a hash of a file."""
    return blake2b(file.read_bytes(), digest_size=16).hexdigest()


def parts_of(out: Path) -> list[Path]:
    """Return the finished part files of a run."""
    return list(out.with_name(out.name + ".parts").glob("part-*.safetensors"))


def write_images(folder: Path, count: int) -> None:
    """Write `count` different JPEGs in pairs, `generated/<class>/<number>_{vis,tac}.jpg`."""
    random = np.random.default_rng(0)
    for number in range(count):
        small = Image.fromarray(random.integers(0, 256, (30, 40, 3), dtype=np.uint8))
        pair = number // 2
        place = folder / "generated" / MATERIALS[pair % len(MATERIALS)]
        place.mkdir(parents=True, exist_ok=True)
        file = place / f"{pair:06}_{('vis', 'tac')[number % 2]}.jpg"
        small.resize((640, 480), Image.Resampling.BILINEAR).save(file, quality=85)
    file.write_bytes(file.read_bytes()[:500])  # the last tactile image, cut short


def watched(images: Path, out: Path, stop_at: int | None) -> dict[str, Any]:
    """Run the command; kill it at a given number of part files. Return its cost."""
    command = [sys.executable, "-m", "omnivat", "embed", str(images), "--out", str(out)]
    began, memory, clock = time.perf_counter(), 0.0, 0.0
    process = subprocess.Popen([*command, "--no-flips"], stdout=subprocess.PIPE, text=True)
    while process.poll() is None:
        memory, clock = map(max, (memory, clock), used(process.pid))
        if stop_at is not None and len(parts_of(out)) >= stop_at:
            process.send_signal(signal.SIGKILL)
            break
        time.sleep(0.2)
    said = process.communicate()[0].splitlines()
    return {
        "peak_mb": round(memory),
        "cpu_s": round(clock, 1),
        "wall_s": round(time.perf_counter() - began, 1),
        "exit": process.returncode,
        "said": said[-1] if said and stop_at is None else "",
    }


def used(pid: int) -> tuple[float, float]:
    """Return the most memory (MB) and the processor time (s) of a process so far; 0 when ended."""
    try:
        status = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
        clocks = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except OSError:
        return 0.0, 0.0
    peak = [int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM")]
    return (peak[0] / 1000 if peak else 0.0), (int(clocks[11]) + int(clocks[12])) / 100


if __name__ == "__main__":
    main()
