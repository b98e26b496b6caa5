"""The commands take the same things: one modality, no classes, a table of other classes."""

from itertools import product

import pytest

from omnivat.cli import main
from omnivat.head import linear_maps
from omnivat.study import trial

KINDS = {  # kind -> names of pictures; the readers' tests have the others
    "photos only": ["lab/{c}/{k}_vis.png"],
    "touches only": ["lab/{c}/{k}_tac.png"],
    "no classes": ["{c}{k}_vis.png", "{c}{k}_tac.png"],
    "a table": ["lab/{c}/{k}_vis.png", "lab/{c}/{k}_tac.png"],
}


@pytest.fixture(scope="module")
def pictures(paint):
    """Return a maker of a folder with three pictures of each class for each name."""

    def make(root, names, classes=("wood", "steel")):
        for c, k, name in product(classes, range(3), names):
            paint(root / name.format(c=c, k=k))
        return root

    return make


@pytest.fixture(scope="module")
def places(tmp_path_factory, pictures):
    """Return kind -> (pictures, their embeddings by `embed`)."""
    found = {}
    for kind, names in KINDS.items():
        root = tmp_path_factory.mktemp("set")
        classes = ("cork", "felt") if kind == "a table" else ("wood", "steel")
        place = pictures(root / "mine", names, classes)
        if kind == "a table":
            rows = [",".join([*names, "lab,{c}"]).format(c=c, k=k) for c in classes for k in "012"]
            place = place / "list.csv"
            place.write_text("\n".join(["vis,tac,domain,material", *rows]))
        out = root / "set.safetensors"
        assert main(["embed", str(place), "--no-flips", "--out", str(out)]) == 0
        found[kind] = place, out
    return found


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("command", ["try", "profile", "predict", "teach", "report"])
def test_every_command_takes_every_kind_or_says_what_it_wants(
    command, kind, places, tmp_path, run, monkeypatch
):
    monkeypatch.setattr(trial, "EPOCHS", 1)
    monkeypatch.setattr(linear_maps, "PLAIN_STEPS", 9)
    place, file = places[kind]
    out = tmp_path / "out.safetensors"
    line = {
        "try": ["try", place, "--no-page", "--encoder", "strip", "--out", tmp_path / "out"],
        "profile": ["profile", place, "--encoder", "strip", "--out", out],
        "predict": ["predict", "--pairs", place, "--no-cache"],
        "teach": ["teach", "--embeddings", file, "--out", tmp_path / "out"],
        "report": ["report", file, "--out", tmp_path / "out"],
    }[command]
    if command == "teach" and kind == "no classes":
        said = run(*line, code=1).err
        assert "have no classes, and teaching needs labels: embed them from" in said
        return
    said = run(*line).out
    one, other = {"touches only": ("tactile images", "photo")}.get(kind, ("photos", "tactile"))
    if command == "predict" and kind.endswith("only"):
        assert f"no {'VIS' if other == 'photo' else 'TAC'}" in said
    if command == "profile" and kind.endswith("only"):
        assert f"6 {one}" in said and other not in said
    if command == "try":
        last = said.strip().splitlines()[-2]
        assert last.startswith("No head was trained" if kind == "no classes" else "In short: ")
        assert (tmp_path / "out" / "set.thumbnails.webp").is_file()


@pytest.mark.parametrize("command", ["teach", "report"])
def test_pictures_in_place_of_embeddings_end_in_the_command_that_makes_them(
    command, tmp_path, run, pictures
):
    place = pictures(tmp_path / "mine", KINDS["touches only"])
    named = ["--embeddings", place] if command == "teach" else [place]
    said = run(command, *named, "--out", tmp_path / "out", code=1).err
    assert f"python -m omnivat embed {place} --out" in said and said.count("\n") == 1


@pytest.mark.parametrize("command", ["embed", "try", "profile", "predict"])
def test_pictures_whose_names_tell_nothing_end_in_the_names_that_would(
    command, tmp_path, run, pictures
):
    place = pictures(tmp_path / "mine", ["IMG_{c}{k}.png"])
    line = ["--pairs", place] if command == "predict" else [place]
    more = ["--out", tmp_path / "out.safetensors"] if command in ("embed", "profile") else []
    said = run(command, *line, *more, code=1).err
    assert "_vis.png" in said and "_tac.png" in said and said.count("\n") == 1
