"""How time and memory grow with the set: `python -m benchmarks.scale --out docs/benchmarks/scale.json`.

The sets have 1,000 to 500,000 synthetic pairs (random numbers around a class mean; nothing is
learned from them); the head has the shipped settings. Each task runs in a separate process with
its own peak memory. Seconds are wall time; on a shared machine, use CPU seconds. The exponent is
the slope of log CPU seconds over log pairs, from the two largest sizes.
"""

import argparse
import json
import math
import os
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

from benchmarks.measure import machine
from omnivat.measure.gaps import GAPS

SIZES = (1_000, 10_000, 100_000, 500_000)
WIDTH, CLASSES, DOMAINS = 512, 5, 4
LIMIT_S = 300
OUT = Path("docs/benchmarks/scale.json")


def make_set(folder: Path, pairs: int) -> Path:
    """Write a set of synthetic pairs, block by block; return its file."""
    import numpy as np

    from omnivat.data.arrays import Column
    from omnivat.data.store import ROW_NAMES, Header, write_columns

    file = folder / f"{pairs}.safetensors"
    random = np.random.default_rng(0)
    label, domain = random.integers(0, CLASSES, pairs), random.integers(0, DOMAINS, pairs)
    means = random.standard_normal((2, CLASSES, WIDTH)).astype(np.float32)
    header = Header(
        encoder="made",
        weights_hash="0" * 16,
        preprocessing="none",
        domains=tuple(f"domain {k}" for k in range(DOMAINS)),
        classes=tuple(f"class {k}" for k in range(CLASSES)),
        simulated=True,
        origin="random numbers",
    )

    def blocks(modality: int) -> Any:
        for start in range(0, pairs, 10_000):
            of = label[start : start + 10_000]
            yield means[modality, of] + 2 * random.standard_normal((len(of), WIDTH), np.float32)

    vectors = {
        name: Column(dtype="F32", shape=(pairs, WIDTH), blocks=blocks(k)) for k, name in enumerate(("vis", "tac"))
    }
    rows = {name: [""] * pairs for name in ROW_NAMES}
    rows |= {name: [f"{name}/{k:06d}.png" for k in range(pairs)] for name in ("vis", "tac")}
    write_columns(file, header, vectors, domain=domain, label=label, rows=rows)
    return file


def make_head(folder: Path) -> Path:
    """Write an untrained head that fits the synthetic sets."""
    import torch

    from omnivat.head.checkpoint import Head, save_head
    from omnivat.head.head import OmniVaT
    from omnivat.head.settings import HeadSettings

    torch.manual_seed(0)
    names = tuple(f"class {k}" for k in range(CLASSES))
    settings = HeadSettings(classes=names, input_width=WIDTH)
    made = {"name": "made", "weights_hash": "0" * 16, "preprocessing": "none"}
    head = Head(model=OmniVaT(settings), settings=settings, encoder=made, provenance={"source": "domain 0"})
    return save_head(folder / "head", head)


def evaluate(head: Path, file: Path, out: Path) -> None:
    """Accuracy of the head in each domain."""
    command("evaluate", "--head", head, "--embeddings", file)


def gaps(measure: str, head: Path, file: Path, out: Path) -> None:
    """One gap between modalities and domains, of raw embeddings."""
    command("gaps", "--stage", "raw", "--measure", measure, "--embeddings", file)


def project(method: str, head: Path, file: Path, out: Path) -> None:
    """A map of raw embeddings, with its faithfulness."""
    map_of = ("--stage", "raw", "--method", method, "--embeddings", file)
    command("project", *map_of, "--out", out / "map.csv")


def profile(head: Path, file: Path, out: Path) -> None:
    """The profile of one domain."""
    command("profile", file, "--domain", "domain 0", "--out", out / "profile.safetensors")


def report(head: Path, file: Path, out: Path) -> None:
    """The report without a head, of 4,000 random pairs."""
    command("report", file, "--out", out / "report")


def sweep(head: Path, file: Path, out: Path) -> None:
    """Curves over 3 orders."""
    command("sweep", "--head", head, "--embeddings", file, "--orders", "0,0.5,1", "--csv", out / "sweep.csv")


def train(head: Path, file: Path, out: Path) -> None:
    """One epoch on one domain, then the scores on all of them."""
    made = ("--set", "epochs=1", "--set", "lang=false", "--no-calibration")
    command("train", *made, "--source", "domain 0", "--embeddings", file, "--out", out / "trained")


def page(head: Path, file: Path, out: Path) -> None:
    """Open the set in the page's server until its first map is there."""
    from time import sleep

    os.environ["OMNIVAT_CACHE"] = str(out / "cache")
    from app.places import places
    from app.resources import Resources

    resources = Resources(places(head, file))
    while (state := resources.frames.state()).file is None:
        if state.problem:
            raise SystemExit(state.problem)
        sleep(0.05)
    resources.shared.jobs.close()


TASKS: dict[str, Callable[[Path, Path, Path], None]] = {
    "evaluate": evaluate,
    **{f"gaps {name}": partial(gaps, name) for name in GAPS},
    "project pca": partial(project, "pca"),
    "project umap": partial(project, "umap"),
    "profile": profile,
    "report": report,
    "sweep": sweep,
    "train": train,
    "page": page,
}


def command(*words: Any) -> None:
    """Run one command of the program in this process."""
    from omnivat.cli import main as program

    status = program([str(word) for word in words])
    if status:
        raise SystemExit(f"{words[0]} ended with {status}")


def once(task: str, head: Path, file: Path) -> None:
    """Run one task here and print its seconds and peak memory as JSON."""
    with TemporaryDirectory() as folder:
        began = perf_counter()
        TASKS[task](head, file, Path(folder))
        seconds = perf_counter() - began
        used = getrusage(RUSAGE_SELF)
    peak = used.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    found = {"seconds": seconds, "processor_s": used.ru_utime + used.ru_stime}
    rounded = {name: round(value, 2) for name, value in found.items()}
    print(json.dumps({**rounded, "peak_mb": round(peak / 1e6)}), flush=True)
    os._exit(0)  # the page's server may still compute the next map


def run_apart(task: str, head: Path, file: Path, limit_s: float) -> dict[str, Any]:
    """Run one task in a separate process; return the reason if it fails."""
    words = ["--once", task, "--head", str(head), "--embeddings", str(file)]
    call = [sys.executable, "-m", "benchmarks.scale", *words]
    try:
        done = subprocess.run(call, capture_output=True, text=True, timeout=limit_s, check=False)
    except subprocess.TimeoutExpired:
        return {"stopped": f"over {limit_s:.0f} s"}
    if done.returncode:
        return {"stopped": (done.stderr.strip().splitlines() or ["killed"])[-1][:200]}
    found: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return found


def exponent(rows: dict[str, dict[str, Any]]) -> float | None:
    """Return the slope of log time over log pairs between the two largest finished sizes."""
    ended = [(int(n), row["processor_s"]) for n, row in rows.items() if row.get("processor_s")]
    if len(ended) < 2:
        return None
    (n1, t1), (n2, t2) = sorted(ended)[-2:]
    return round(math.log(t2 / t1) / math.log(n2 / n1), 2)


def main(arguments: list[str] | None = None) -> int:
    """Measure all tasks at all sizes, or one task with --once."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=list(SIZES))
    parser.add_argument("--tasks", nargs="+", choices=list(TASKS), default=list(TASKS))
    parser.add_argument("--limit", type=float, default=LIMIT_S, help="seconds for one task")
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--table", action="store_true", help="only print --out as a table")
    parser.add_argument("--once", choices=list(TASKS), help=argparse.SUPPRESS)
    parser.add_argument("--head", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--embeddings", type=Path, help=argparse.SUPPRESS)
    chosen = parser.parse_args(arguments)
    if chosen.once:
        once(chosen.once, chosen.head, chosen.embeddings)
        return 0
    if chosen.table:
        print(table(chosen.out))
        return 0
    found: dict[str, dict[str, Any]] = {task: {} for task in chosen.tasks}
    with TemporaryDirectory() as folder:
        head = make_head(Path(folder))
        for size in sorted(chosen.sizes):
            file = make_set(Path(folder), size)
            for task in chosen.tasks:
                row = run_apart(task, head, file, chosen.limit)
                found[task][str(size)] = row
                print(f"{task:15} {size:8,} {row}", flush=True)
                write(chosen.out, found)
            file.unlink()
    return 0


def table(out: Path) -> str:
    """Return the record as a Markdown table: processor seconds and peak memory of each task."""
    record = json.loads(out.read_text(encoding="utf-8"))
    sizes = sorted({int(n) for one in record["tasks"].values() for n in one["sizes"]})
    lines = [
        "| task | " + " | ".join(f"{n:,} pairs" for n in sizes) + " | exponent |",
        "| --- |" + " --- |" * (len(sizes) + 1),
    ]
    for task, one in record["tasks"].items():
        cells = [_cell(one["sizes"].get(str(n), {})) for n in sizes]
        lines.append(f"| {task} | " + " | ".join(cells) + f" | {one['exponent']} |")
    return "\n".join(lines)


def _cell(row: dict[str, Any]) -> str:
    if "processor_s" not in row:
        return str(row.get("stopped", "not measured"))
    return f"{row['processor_s']:.3g} s, {row['peak_mb'] / 1000:.2f} GB"


def write(out: Path, found: dict[str, dict[str, Any]]) -> None:
    """Write the results so far."""
    from omnivat.kit.files import write_json

    tasks = {task: {"sizes": rows, "exponent": exponent(rows)} for task, rows in found.items()}
    write_json(out, {"machine": machine(), "width": WIDTH, "tasks": tasks})


if __name__ == "__main__":
    sys.exit(main())
