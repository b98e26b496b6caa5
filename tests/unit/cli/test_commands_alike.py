"""The commands take the same things: pairs, one modality, tables, other classes, none."""

from itertools import product

import pytest

from omnivat.cli import main
from omnivat.data.store import load_embeddings
from omnivat.head import linear_maps
from omnivat.study import trial

FOLDERS = {  # kind -> names of pictures
    "pairs": ["lab/{c}/{k}_vis.png", "lab/{c}/{k}_tac.png"],
    "photos only": ["lab/{c}/{k}_vis.png"],
    "touches only": ["lab/{c}/{k}_tac.png"],
    "folders vis and tac": ["vis/{c}{k}.png", "tac/{c}{k}.png"],
    "no classes": ["{c}{k}_vis.png", "{c}{k}_tac.png"],
}
TABLES = {  # kind -> its columns
    "a table": ["vis", "tac", "domain", "material"],
    "a table without domains": ["vis", "tac", "label"],
    "a table of touches": ["tac", "class"],
}
BARE = ("folders vis and tac", "no classes")


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
    for kind in (*FOLDERS, *TABLES):
        root = tmp_path_factory.mktemp("set")
        classes = ("cork", "felt") if kind == "a table" else ("wood", "steel")
        place = pictures(root / "mine", FOLDERS.get(kind, FOLDERS["pairs"]), classes)
        if kind in TABLES:
            lines = [",".join(TABLES[kind])]
            for c in classes:
                for k in range(3):
                    cells = {n: f"lab/{c}/{k}_{n}.png" for n in ("vis", "tac")} | {"domain": "lab"}
                    lines.append(",".join(cells.get(name, c) for name in TABLES[kind]))
            place = place / "list.csv"
            place.write_text("\n".join(lines) + "\n")
        assert main(["embed", str(place), "--out", str(root / "set.safetensors")]) == 0
        found[kind] = place, root / "set.safetensors"
    return found


@pytest.mark.parametrize("kind", [*FOLDERS, *TABLES])
@pytest.mark.parametrize("command", ["try", "profile", "predict", "teach", "report"])
def test_every_command_takes_every_kind_or_says_what_it_wants(
    command, kind, places, tmp_path, run, monkeypatch
):
    monkeypatch.setattr(trial, "EPOCHS", 1)
    monkeypatch.setattr(linear_maps, "PLAIN_STEPS", 9)
    place, file = map(str, places[kind])
    out = str(tmp_path / "out")
    line = {
        "try": ["try", place, "--no-page", "--encoder", "strip", "--out", out],
        "profile": ["profile", place, "--encoder", "strip", "--out", f"{out}.safetensors"],
        "predict": ["predict", "--pairs", place, "--no-cache"],
        "teach": ["teach", "--embeddings", file, "--out", out],
        "report": ["report", file, "--out", out],
    }[command]
    if command == "teach" and kind in BARE:
        said = run(*line, code=1).err
        assert "have no classes, and teaching needs labels: embed them from" in said
        return
    said = run(*line)
    alone = {"photos only": "vis", "touches only": "tac", "a table of touches": "tac"}.get(kind)
    if alone and command == "predict":
        assert {"vis": "no TAC", "tac": "no VIS"}[alone] in said.out
    if alone and command == "profile":
        one, other = {"vis": ("6 photos", "tactile"), "tac": ("6 tactile images", "photo")}[alone]
        assert one in said.out and other not in said.out
    if command == "try":
        last = said.out.strip().splitlines()[-2]
        assert last.startswith("No head was trained" if kind in BARE else "In short: ")


@pytest.mark.parametrize("kind", ["pairs", "a table"])
@pytest.mark.parametrize("command", ["teach", "report"])
def test_pictures_in_place_of_embeddings_end_in_the_command_that_makes_them(
    command, kind, places, tmp_path, run
):
    place = places[kind][0]
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


def test_the_column_of_a_table_tells_that_its_pictures_are_touches(tmp_path, run, pictures):
    place = pictures(tmp_path / "mine", ["{c}{k}.png"]) / "list.csv"
    place.write_text("tac\nwood0.png\n")
    line = [
        "embed",
        place,
        "--encoder",
        "strip",
        "--no-flips",
        "--out",
        tmp_path / "out.safetensors",
    ]
    assert "touches alone" in run(*line).out
    assert load_embeddings(tmp_path / "out.safetensors").header.modalities == ("tac",)
