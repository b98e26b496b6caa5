"""Each long command is killed once while it writes: nothing half-written stands, and it can run
again.
"""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from omnivat import cli
from omnivat.cli import main
from omnivat.kit import files
from simulator.__main__ import COMMANDS as DRAWING

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[3]
# Torch loads once for all commands; each runs in a fork, which dies just before a file that it has
# written takes its place.
SCRIPT = """
import json, os, signal, sys
import torch, omnivat.training
from omnivat.cli import COMMANDS, main
from simulator.__main__ import COMMANDS as DRAWING

def dies(real):
    def place(*names, **options):
        global left
        if left == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        left -= 1
        return real(*names, **options)
    return place

for left, words in json.loads(sys.argv[1]):
    if child := os.fork():
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
    else:
        os.replace, os.rename = dies(os.replace), dies(os.rename)
        sys.stdout = sys.stderr
        sys.exit(main(words, commands={**COMMANDS, **DRAWING}))
"""

TRAIN = "--source TAG-sim --set width=16 --set epochs=2 --set lang=false --no-calibration"
# command, its arguments, what it makes, and after how many files it is killed
COMMANDS = {
    "train": (f"--embeddings {{set}} {TRAIN} --out {{out}}/head", "head", 2),
    "sweep": (
        "--head {head} --embeddings {set} --orders 0,0.5 --out {out}/f.bin --json {out}/c.json",
        "f.bin",
        1,
    ),
    "embed": ("{pairs} --encoder strip --out {out}/e.safetensors", "e.safetensors", 2),
    "protocol": (
        "--embeddings {set} --methods nearest_mean --seeds 0 --out {out}/records",
        "records",
        0,
    ),
    "chirps": ("--pairs-per-class 4 --out {out}/chirps", "chirps", 30),
    "export": ("--frames {frames} --out {out}/map.svg", "map.svg", 0),
    "thumbnails": ("{pairs} --embeddings {embedded} --out {out}/s.webp", "s.webp", 1),
}


def arguments(command, names):
    """Return a command line with the names filled in."""
    return [command, *(part.format(**names) for part in COMMANDS[command][0].split())]


@pytest.fixture(scope="module")
def names(tmp_path_factory, head_folder, paint):
    """Return what the arguments name: a small head and set, frames, and a folder of pairs."""
    folder = tmp_path_factory.mktemp("kills")
    for k in range(6):
        for modality in ("vis", "tac"):
            paint(folder / "pairs" / f"TAG-sim/wood/{k}_{modality}.png")
    embedded = folder / "embedded.safetensors"
    assert main(["embed", str(folder / "pairs"), "--encoder", "strip", "--out", str(embedded)]) == 0
    return {
        "set": head_folder.parent / "set.safetensors",
        "head": head_folder,
        "frames": ROOT / "examples" / "frames.bin",
        "pairs": folder / "pairs",
        "embedded": embedded,
    }


@pytest.fixture(scope="module")
def killed(names, tmp_path_factory):
    """Return command -> the folder that it wrote to until it was killed, and its exit code."""
    places = {command: tmp_path_factory.mktemp(command) for command in COMMANDS}
    lines = [
        (COMMANDS[command][2], [*map(str, arguments(command, names | {"out": place}))])
        for command, place in places.items()
    ]
    ended = subprocess.run(
        [sys.executable, "-c", SCRIPT, json.dumps(lines)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        timeout=600,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        check=True,
    )
    codes = map(int, ended.stdout.split())
    return dict(zip(places, zip(places.values(), codes, strict=True), strict=True))


@pytest.mark.parametrize("command", COMMANDS)
def test_a_killed_command_leaves_nothing_half_written_and_runs_again(
    command, names, killed, monkeypatch
):
    place, code = killed[command]
    assert code == -signal.SIGKILL
    standing = {p: p.read_bytes() for p in shown(place)}
    assert standing or command not in ("embed", "chirps"), "the next run uses what is there"
    monkeypatch.setattr(files, "UNFINISHED_S", -1)  # what the dead left need not grow old
    assert (
        main(arguments(command, names | {"out": place}), commands={**cli.COMMANDS, **DRAWING}) == 0
    )
    assert (place / COMMANDS[command][1]).exists()
    whole = {p: p.read_bytes() for p in shown(place)}
    for file, content in standing.items():  # what stood after the kill was whole
        if file in whole and file.suffix in (".png", ".webp", ".safetensors", ".svg", ".bin"):
            assert whole[file] == content, file.name
    assert [p.name for p in place.rglob("*") if p.name.endswith((".tmp", ".old"))] == []
    assert [p.name for p in place.iterdir() if p.name.startswith(".")] == []


STOPPED = """
import atexit, os, signal, sys
from omnivat.cli import main

class Finder:  # sends the signal while torch loads
    def find_spec(self, name, *_):
        if name == "torch.nn":
            os.kill(os.getpid(), signal.SIGTERM)

sys.meta_path.insert(0, Finder())
atexit.register(lambda: print("torch is", "whole" if "torch.optim" in sys.modules else "cut off"))
sys.exit(main())
"""


def test_a_command_that_is_stopped_while_torch_loads_ends_in_a_sentence():
    ended = subprocess.run(
        [sys.executable, "-c", STOPPED, "evaluate"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert (ended.returncode, ended.stdout) == (143, "torch is whole\n")
    assert ended.stderr == "Stopped. Nothing is half-written.\n"


def test_help_needs_no_docstrings():
    words = [sys.executable, "-OO", "-m", "omnivat", "--help"]
    ended = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=600, check=True)
    assert all(name in ended.stdout for name in cli.SUMMARIES)
    assert all(text.endswith(".") and text[0].isupper() for text in cli.SUMMARIES.values())


def shown(folder):
    """Return the files of a folder that are not a writer's own temporary ones."""
    return [
        p
        for p in folder.rglob("*")
        if p.is_file() and not any(part.startswith(".") for part in p.relative_to(folder).parts)
    ]
