"""Peak memory of `omnivat protocol` on random embeddings, as many as in the paper.

python -m benchmarks.protocol_memory [--width 512] [--source "OF 2.0 B"] [--methods omnivat] [--epochs 1]
"""

import argparse
import resource
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from omnivat.data.store import Embeddings, Header, save_embeddings

CLASSES = ("wood", "steel", "plastic", "ceramic", "glass")
# Domain -> the paper's training and test pairs by part.
OUTDOOR, INDOOR = ("outdoor", 779, 285), ("indoor", 0, 525)
SIZES = {
    "TAG": (("", 5520, 1770),),
    "OF Real": (("", 3401, 1355),),
    "OF 2.0 A": (("", 1000, 2200),),
    "OF 2.0 B": (("", 9500, 2500),),
    "TQ-DIGIT": (OUTDOOR, INDOOR),
    "TQ-GelMini": (OUTDOOR, INDOOR),
    "TQ-DuraGel": (OUTDOOR, INDOOR),
    "TQ-T3D": (("indoor", 1196, 682),),
}


def made(width: int) -> Embeddings:
    """Return random embeddings with mirrored copies, D = width; classes are directions."""
    random = np.random.default_rng(0)
    rows = [
        (number, part, split)
        for number, parts in enumerate(SIZES.values())
        for part, train, test in parts
        for split, count in (("train", train), ("test", test))
        for _ in range(count)
    ]
    domain = np.array([row[0] for row in rows])
    label = np.arange(len(rows)) % 5
    label[(label == 3) & (domain >= 4)] = 0  # TacQuad has no ceramic
    centres = random.normal(size=(5, width))
    vectors = [(centres[label] + random.normal(size=(len(rows), width))).astype(np.float32) for _ in range(4)]
    names = [str(index) for index in range(len(rows))]
    header = Header(
        encoder="made",
        weights_hash="0" * 16,
        preprocessing="none",
        domains=tuple(SIZES),
        classes=CLASSES,
        simulated=True,
        origin="made for a measurement",
    )
    return Embeddings(
        header=header,
        vis=vectors[0],
        tac=vectors[1],
        vis_flip=vectors[2],
        tac_flip=vectors[3],
        domain=domain,
        label=label,
        rows={
            "vis": names,
            "tac": names,
            "object": [f"{d}/{c}/{i // 50}" for i, (d, c) in enumerate(zip(domain, label, strict=True))],
            "split": [row[2] for row in rows],
            "part": [row[1] for row in rows],
            "looks_like": [""] * len(rows),
            "feels_like": [""] * len(rows),
        },
    )


def main() -> None:
    """Write the embeddings, run the command in a separate process, print its peak memory."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--width", type=int, default=512)
    parser.add_argument("--source", default="OF 2.0 B")
    parser.add_argument("--methods", default="omnivat")
    parser.add_argument("--epochs", type=int, default=1)
    options = parser.parse_args()
    with TemporaryDirectory() as folder:
        file = Path(folder) / "set.safetensors"
        save_embeddings(file, made(options.width))
        size = file.stat().st_size
        command = [sys.executable, "-m", "omnivat", "protocol", "--embeddings", str(file)]
        command += ["--out", str(Path(folder) / "out"), "--methods", options.methods]
        command += ["--sources", options.source, "--seeds", "0", "--set", f"epochs={options.epochs}"]
        began = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        seconds = time.perf_counter() - began
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    pairs = sum(train + test for parts in SIZES.values() for _, train, test in parts)
    print(
        f"{pairs:,} pairs, D = {options.width}, file {size / 2**20:.0f} MiB; {options.methods} from "
        f"{options.source}, {options.epochs} epoch: peak {peak:.0f} MiB, {seconds:.0f} s"
    )


if __name__ == "__main__":
    main()
