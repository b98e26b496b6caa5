"""Commands are killed once while they write a folder, several files, records or many pictures:
nothing half-written stands, and they can run again.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from omnivat import cli
from omnivat.cli import main
from omnivat.data.store import save_embeddings
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
    "embed": ("{pairs} --encoder strip --out {out}/e.safetensors", "e.safetensors", 2),
    "protocol": (
        "--embeddings {set} --methods nearest_mean --seeds 0 --out {out}/records",
        "records",
        0,
    ),
    "chirps": ("--pairs-per-class 4 --out {out}/chirps", "chirps", 30),
}


def arguments(command, names):
    """Return a command line with the names filled in."""
    return [command, *(part.format(**names) for part in COMMANDS[command][0].split())]


@pytest.fixture(scope="module")
def names(tmp_path_factory, make_embeddings, paint):
    """Return what the arguments name: a small set, and a folder of pairs."""
    folder = tmp_path_factory.mktemp("kills")
    for k in range(6):
        for modality in ("vis", "tac"):
            paint(folder / "pairs" / f"TAG-sim/wood/{k}_{modality}.png")
    save_embeddings(folder / "set.safetensors", make_embeddings())
    return {"set": folder / "set.safetensors", "pairs": folder / "pairs"}


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
def test_a_killed_command_leaves_nothing_half_written_and_runs_again(command, names, killed):
    place, code = killed[command]
    assert code == -signal.SIGKILL
    standing = {p: p.read_bytes() for p in shown(place)}
    assert standing or command not in ("embed", "chirps"), "the next run uses what is there"
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


def test_a_command_that_is_stopped_while_torch_loads_ends_in_a_sentence(monkeypatch, capsys):
    spec, reached = SimpleNamespace(_initializing=True), []

    def run(_):
        signal.raise_signal(signal.SIGTERM)
        reached.append("torch is whole")
        spec._initializing = False
        for _ in range(6_000):
            time.sleep(0.01)

    waits = SimpleNamespace(__doc__="It waits.", add=lambda _: None, run=run)
    monkeypatch.setitem(sys.modules, "torch", SimpleNamespace(__spec__=spec))
    monkeypatch.setattr(sys, "argv", ["omnivat", "waits"])
    kept = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        assert main(commands={"waits": waits}) == 143
    finally:
        for number, handler in kept.items():
            signal.signal(number, handler)
    assert reached and capsys.readouterr().err == "Stopped. Nothing is half-written.\n"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_python_ends_after_a_command_changes_nothing(number):
    script = (
        "import atexit, sys; from signal import raise_signal; from types import SimpleNamespace;"
        f" atexit.register(raise_signal, {int(number)}); from omnivat.cli import main;"
        " work = SimpleNamespace(__doc__='It works.', add=lambda _: None, run=lambda _: None);"
        " sys.exit(main(commands={'works': work}))"
    )
    done = subprocess.run([sys.executable, "-c", script, "works"], capture_output=True, cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, b"")


def shown(folder):
    """Return the files of a folder that are not a writer's own temporary ones."""
    return [
        p
        for p in folder.rglob("*")
        if p.is_file() and not any(part.startswith(".") for part in p.relative_to(folder).parts)
    ]
