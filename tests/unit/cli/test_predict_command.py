"""`omnivat predict` on a set of pairs, some of which cannot be read."""

import json
from pathlib import Path
from shutil import copytree

import pytest
from PIL import Image

from omnivat.data.rest import RESTED
from omnivat.head.heads import default_head


@pytest.fixture
def folder(tmp_path, paint):
    """A folder of three pairs in a path with a space and a letter beyond ASCII."""
    for name in ("a", "b", "c"):
        for half in ("vis", "tac"):
            paint(tmp_path / "mine ü" / "lab" / "wood" / f"{name}_{half}.png")
    return tmp_path / "mine ü"


def spoil(folder, *names):
    for name in names:
        file = folder / "lab" / "wood" / name
        file.write_bytes(file.read_bytes()[:60])


def test_pairs_that_cannot_be_read_are_named_and_the_others_answered(folder, run):
    spoil(folder, "b_tac.png")
    said = run("predict", "--pairs", folder, "--json", "--no-cache")
    answers = json.loads(said.out)
    assert [Path(answer["vis"]).name for answer in answers] == ["a_vis.png", "c_vis.png"]
    assert said.err.startswith("skipped: ") and "b_tac.png" in said.err
    assert said.err.count("\n") == 1


@pytest.mark.parametrize("single", [True, False])
def test_pictures_of_which_nothing_can_be_read_are_an_error_without_json(single, folder, run):
    spoil(folder, "a_vis.png", "b_tac.png", "c_vis.png")
    files = [folder / "lab" / "wood" / f"a_{half}.png" for half in ("vis", "tac")]
    asked = files if single else ["--pairs", folder]
    said = run("predict", *asked, "--json", "--no-cache", code=1)
    last = said.err.splitlines()[-1]
    assert said.out == "" and ("a_vis.png" if single else "None of the 3 pairs in") in last


def test_a_head_of_rest_pictures_uses_the_one_given_and_tells_when_it_needs_one(
    folder, tmp_path, run
):
    head = tmp_path / "head"
    copytree(default_head(), head)
    settings = json.loads((head / "settings.json").read_text())
    settings["encoder"]["preprocessing"] += RESTED
    (head / "settings.json").write_text(json.dumps(settings))
    place = folder / "lab" / "wood"
    rest = place.parent / "rest.png"
    Image.new("RGB", (32, 32), (90, 120, 150)).save(rest)
    base = "predict", "--json", "--no-cache"
    pair = place / "a_vis.png", place / "a_tac.png"

    def touch(*words):
        found = json.loads(run(*base, *words).out)
        return (found[0] if isinstance(found, list) else found)["modalities"]["tac"]

    own = "--head", head
    rested = touch(*pair, *own, "--tac-rest", rest)
    assert rested != touch(*pair, *own, "--tac-rest", "none")
    assert touch("--pairs", folder, *own) == rested  # rest.png lies in the domain's folder
    said = run(*base, *pair, *own, code=1).err
    assert "name the picture of your untouched sensor" in said
    said = run(*base, *pair, "--tac-rest", rest, code=1).err
    assert "trained on tactile images as they come" in said
