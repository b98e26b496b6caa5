"""What the README shows runs as it is written: its lines and its Python, in order, on a few of the
shipped pairs.
"""

import os
import re
import shlex
import socket
import subprocess
import sys
import time
from pathlib import Path
from urllib.request import urlopen

import pytest

from app.shared import resources
from app.shared.places import find_examples
from omnivat.cli import main
from omnivat.head import linear_maps
from omnivat.study import trial

ROOT = Path(__file__).resolve().parents[3]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```", TEXT, re.M | re.S)
COMMANDS = [words for kind, words in BLOCKS if not kind]
PYTHON = [words for kind, words in BLOCKS if kind == "python"]
# What another block runs: the page, and `try` on pairs
AGAIN = (
    "python -m pip install -r requirements.txt && python app.py\n",
    "python -m omnivat try PAIRS\n",
)
NAMES = {"PAIRS": "examples/pairs", "DOMAIN": "TAG-sim"}
LIGHTER = {  # an option that leaves out what costs minutes, or waits for a person
    "try examples/pairs --out mine ": "--encoder strip",
    "embed examples/pairs --out mine": "--encoder strip",
    "train ": "--set epochs=2",
    "export --site": "--no-models --sets sensors",
}


def few_examples(place):
    return dict([*find_examples(place).items()][::12])


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A clone with the pairs of two domains; the first has the ten that a comparison learns."""
    pairs = tmp_path / "examples" / "pairs"
    pairs.mkdir(parents=True)
    (tmp_path / "app.py").symlink_to(ROOT / "app.py")
    for name in ("TAG-sim", "TQ-DIGIT-sim"):
        (pairs / name).symlink_to(ROOT / "examples" / "pairs" / name)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(resources, "find_examples", few_examples)
    monkeypatch.setattr(trial, "EPOCHS", 1)
    monkeypatch.setattr(linear_maps, "PLAIN_STEPS", 10)
    return tmp_path


def serve(words, folder):
    """Start the page, read it once, stop it."""
    with socket.socket() as probe:  # other tests may take the first free port at the same time
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    environ = os.environ | {"BROWSER": "true", "GRADIO_SERVER_PORT": str(port)}
    with (folder / "log").open("w+") as log:
        process = subprocess.Popen(
            [sys.executable, *words], cwd=folder, env=environ, stdout=log, stderr=subprocess.STDOUT
        )
        try:
            while True:
                try:
                    with urlopen(f"http://127.0.0.1:{port}/") as answer:
                        assert b"OmniVaT" in answer.read()
                    return
                except OSError:
                    log.seek(0)
                    assert process.poll() is None, log.read()
                    time.sleep(0.05)
        finally:
            process.terminate()
            process.wait()


@pytest.mark.slow
@pytest.mark.parametrize("block", [b for b in COMMANDS if b not in AGAIN])
def test_the_lines_of_a_block_run_one_after_the_other(block, folder, capsys):
    for line in block.splitlines():
        python, *words = (NAMES.get(word, word) for word in shlex.split(line))
        assert python == "python"
        if words == ["app.py"]:
            continue  # as every journey in a browser starts it
        if words[0] == "app.py":
            serve(words, folder)
            continue
        assert words[:2] == ["-m", "omnivat"]
        words = words[2:]
        more = next((o for part, o in LIGHTER.items() if " ".join(words).startswith(part)), "")
        done = main([*words, *(more.split() if more not in words else [])])
        assert done == 0, capsys.readouterr().err


def test_a_block_that_is_not_run_holds_what_another_runs():
    for block, again in zip(AGAIN, ("python app.py", "python -m omnivat try"), strict=True):
        assert block in COMMANDS
        assert any(f"\n{again}" in f"\n{other}" for other in COMMANDS if other not in AGAIN)


@pytest.mark.parametrize("code", PYTHON)
def test_the_python_of_the_readme_runs(code, capsys):
    from torch import randn

    exec(code, {"x": randn(2, 16)})  # the README's own text
    assert "predict_pair" not in code or capsys.readouterr().out.startswith("glass {")
