"""`omnivat predict` on a set of pairs, some of which cannot be read."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from omnivat.cli import main


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder of three pairs in a path with a space and a letter beyond ASCII."""
    random = np.random.default_rng(0)
    place = tmp_path / "mine ü" / "lab" / "wood"
    place.mkdir(parents=True)
    for name in ("a", "b", "c"):
        for half in ("vis", "tac"):
            pixels = random.integers(0, 256, (24, 32, 3), dtype=np.uint8)
            Image.fromarray(pixels).save(place / f"{name}_{half}.png")
    return tmp_path / "mine ü"


def spoil(folder: Path, *names: str) -> None:
    for name in names:
        file = folder / "lab" / "wood" / name
        file.write_bytes(file.read_bytes()[:60])


def test_pairs_that_cannot_be_read_are_named_and_the_others_answered(folder, capsys):
    spoil(folder, "b_tac.png")
    assert main(["predict", "--pairs", str(folder), "--json", "--no-cache"]) == 0
    said = capsys.readouterr()
    answers = json.loads(said.out)
    assert [Path(answer["vis"]).name for answer in answers] == ["a_vis.png", "c_vis.png"]
    assert said.err.startswith("skipped: ") and "b_tac.png" in said.err
    assert said.err.count("\n") == 1


def test_a_set_of_which_nothing_can_be_read_is_an_error_without_json(folder, capsys):
    spoil(folder, "a_vis.png", "b_tac.png", "c_vis.png")
    assert main(["predict", "--pairs", str(folder), "--json", "--no-cache"]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert "None of the 3 pairs in" in said.err.splitlines()[-1]


def test_a_single_pair_that_cannot_be_read_is_an_error_without_json(folder, capsys):
    spoil(folder, "a_vis.png")
    place = folder / "lab" / "wood"
    files = [str(place / "a_vis.png"), str(place / "a_tac.png")]
    assert main(["predict", *files, "--json", "--no-cache"]) == 1
    said = capsys.readouterr()
    assert said.out == "" and "a_vis.png" in said.err and said.err.count("\n") == 1
