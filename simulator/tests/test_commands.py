"""`python -m simulator`: bad input is one sentence, before any work."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_the_package_runs_as_a_module_and_lists_its_commands():
    command = [sys.executable, "-m", "simulator", "--help"]
    said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert all(name in said for name in ("set", "twins", "chirps"))


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["sett"], "no command 'sett'. Did you mean 'set'?"),
        (["set", "--out", "x", "--workers", "-1"], "'-1'; give a whole number, 1 or more"),
        (["chirps", "--out", "x", "--workers", "2"], "unrecognized arguments: --workers"),
    ],
)
def test_wrong_usage_is_one_sentence(words, sentence, run):
    assert sentence in " ".join(run(*words, code=2).err.split())


@pytest.mark.parametrize(
    ("words", "missing"),
    [
        (["set"], "mitsuba, taxim, jax are not installed"),
        (["set", "--domains", "TAG"], "and mitsuba is not installed"),
        (["twins"], "`python -m simulator twins --gels --out DIR`"),
    ],
)
def test_what_a_request_needs_and_lacks_is_said_before_any_work(
    words, missing, run, tmp_path, monkeypatch
):
    monkeypatch.setattr("simulator.build.find_spec", lambda name: None)
    said = run(*words, "--out", tmp_path / "new", code=1).err
    assert missing in said and said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "words", [["chirps", "--out", "new", "--examples", "file"], ["set", "--out", "file"]]
)
def test_a_file_in_the_place_of_an_output_folder_is_refused_before_any_work(
    words, run, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / "file")
    said = run(*words, code=1).err
    assert f"'{tmp_path / 'file'}' is a file; choose a folder." in said
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
