"""End each long command at random moments, run it again and compare: `python -m benchmarks.stops`.

A command is ended by INT, TERM or KILL at a random share of the time that it takes, and run again
with the same arguments. The files that it then has made should be, byte for byte, those of a run
that nothing disturbed; figures of time in JSON are left out. Beside them nothing should lie about.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from hashlib import blake2b
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks._machine import machine
from omnivat.kit.files import write_json

ROOT, OUT = Path(__file__).parents[1], Path("docs/benchmarks/stops.json")
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
STARTED = (
    0.3  # share of a run in which Python itself starts, before any of our code could end cleanly
)
LONGEST_S = 600
TIMES = ("seconds", "time", "date", "started", "ended")  # endings of keys of such figures
TIMED = "report.md"  # a table with seconds, of records that are compared
SMALL = "--set width=16 --set epochs=4 --set lang=false"
COMMANDS = {  # what each makes lies in {out}; {set} is a set of embeddings, {pairs} a folder
    "embed": "omnivat embed {pairs} --encoder strip --out {out}/e.safetensors",
    "import": "omnivat import {vectors} --encoder x --domain A --out {out}/i.safetensors",
    "import, pictures": "omnivat import {pictures} --out {out}/pairs",
    "train": f"omnivat train --embeddings {{set}} --source {{source}} {SMALL} --out {{out}}/head",
    "sweep": "omnivat sweep --embeddings {set} --head {head} --orders 0,0.5 --out {out}/f.bin",
    "protocol": "omnivat protocol --embeddings {set} --methods linear_maps --seeds 0 --out {out}/r",
    "report": "omnivat report {set} --out {out}/report",
    "export": "omnivat export --frames {frames} --out {out}/map.svg",
    "site": "omnivat export --sets chirps --no-models --site {out}/site",
    "thumbnails": "omnivat thumbnails {pairs} --embeddings {embedded} --out {out}/s.webp",
    "dots": "omnivat dots {pairs} --out {out}/dots",
    "chirps": "simulator chirps --pairs-per-class 6 --out {out}/chirps",
    "twins": "simulator twins --gels --pairs-per-class 1 --workers 1 --out {out}/twins",
}


def prepared(folder: Path) -> dict[str, Path]:
    """Make what the commands take, in a folder; return it by its name in them."""
    chirps = ROOT / "examples" / "chirps"
    names = {"set": chirps / "chirps.safetensors", "head": chirps / "head"}
    names["source"] = Path("Chirps A-sim")
    names |= {"pairs": chirps / "pairs", "frames": chirps / "frames.bin"}
    rows = np.random.default_rng(0).random((3000, 64)).astype("f4")
    vectors, pictures = folder / "v.npz", folder / "p.npz"
    np.savez(vectors, vis=rows, tac=rows, material=["wood", "steel"] * 1500)
    shots = (rows[:192].reshape(64, 4, 48)[..., None] * [255, 200, 100]).astype("u1")
    np.savez(pictures, vis=shots.repeat(12, 1), tac=shots.repeat(12, 1), material=["wood"] * 64)
    names |= {"vectors": vectors, "pictures": pictures, "embedded": folder / "e.safetensors"}
    if started("embed", names, folder).wait():
        raise RuntimeError("the examples cannot be embedded")
    return names


def made_in(folder: Path) -> dict[str, str]:
    """Return the hashes of the files below a folder; of JSON, without figures of time."""

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {k: plain(v) for k, v in value.items() if not k.endswith(TIMES)}
        return [plain(item) for item in value] if isinstance(value, list) else value

    found = {}
    for file in sorted(f for f in folder.rglob("*") if f.is_file() and f.name != TIMED):
        content = file.read_bytes()
        if file.suffix in (".json", ".jsonl"):
            lines = content.splitlines() if file.suffix == ".jsonl" else [content]
            content = json.dumps([plain(json.loads(line)) for line in lines]).encode()
        name = file.relative_to(folder).as_posix()
        found[name] = blake2b(content.replace(bytes(folder), b""), digest_size=8).hexdigest()
    return found


def started(name: str, names: dict[str, Path], out: Path) -> "subprocess.Popen[bytes]":
    """Start a command in a process of its own."""
    words = [word.format(**names, out=out) for word in COMMANDS[name].split()]
    return subprocess.Popen(
        [sys.executable, "-m", *words],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )


def disturbed(
    name: str, names: dict[str, Path], chance: Random, moments: int
) -> Iterator[tuple[str, list[str]]]:
    """Yield for each moment what ended the command, and how a run after it differs: "" and files
    that are not those of an undisturbed run.
    """
    with TemporaryDirectory() as folder:
        out = Path(folder) / "whole"
        out.mkdir()
        began = time.monotonic()
        ended = started(name, names, out)
        _, output = ended.communicate(timeout=LONGEST_S)
        if ended.returncode:
            raise RuntimeError(f"{name} fails undisturbed: {output.decode()}")
        whole, took = made_in(out), time.monotonic() - began
    for k in range(moments):
        with TemporaryDirectory() as folder:
            out = Path(folder) / "whole"
            out.mkdir()
            process, number = started(name, names, out), SIGNALS[k % len(SIGNALS)]
            try:
                process.communicate(timeout=took * (STARTED + (1 - STARTED) * chance.random()))
                how = "over before"
            except subprocess.TimeoutExpired:
                process.send_signal(number)
                _, output = process.communicate(timeout=LONGEST_S)
                how = number.name
            faults = ["a traceback"] if b"Traceback" in output else []
            # the last: Python's own, for any signal that comes while it starts or closes
            if process.returncode not in (0, 128 + number, -number, -signal.SIGINT):
                faults.append(f"it ended with {process.returncode}")
            if made_in(out) != whole:  # else it was over, and some commands replace nothing
                again = started(name, names, out)
                _, output = again.communicate(timeout=LONGEST_S)
                faults += [f"again: {output.decode()[-200:]}"] if again.returncode else []
            made = made_in(out)
            faults += [n for n in sorted({*whole, *made}) if whole.get(n) != made.get(n)]
            yield how, faults


def main() -> int:
    """Print how many runs after a stop made the same bytes; fails if one did not."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--moments", type=int, default=20, help="of each command")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--commands", nargs="+", choices=COMMANDS, default=[*COMMANDS])
    parser.add_argument("--out", type=Path, default=OUT)
    chosen = parser.parse_args()
    record: dict[str, Any] = {"machine": machine(), "moments": chosen.moments, "commands": {}}
    failed = 0
    with TemporaryDirectory() as folder:
        names = prepared(Path(folder))
        for name in chosen.commands:
            chance, ends, fell = Random(f"{chosen.seed} {name}"), Counter[str](), []
            for k, (how, faults) in enumerate(disturbed(name, names, chance, chosen.moments)):
                ends[how] += 1
                fell += [f"moment {k}, {how}: {fault}" for fault in faults]
            failed += len(fell)
            record["commands"][name] = {"ended": dict(ends), "fell": fell}
            print(f"{name:17} {dict(ends)}  differing: {fell or 'none'}", flush=True)
    write_json(chosen.out, record)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
