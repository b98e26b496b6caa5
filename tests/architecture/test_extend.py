"""docs/extend.md, followed to the letter: each addition is one file and at most one line."""

import re
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "extend.md").read_text(encoding="utf-8")


def block(place):
    """Return the code that the page shows for the file at `place`."""
    found = re.search(
        rf"```\w+\n(?:# |// |<!-- ){re.escape(place)}(?: -->)?\n(.*?)```", PAGE, re.DOTALL
    )
    assert found, f"docs/extend.md shows no {place}"
    return found[1]


def entry(table):
    """Return name and target of the line that the page adds to a table."""
    found = re.search(rf'`"(\w+)": "([\w.:]+)"`[^\n]*`{table}`', PAGE)
    assert found, f"docs/extend.md adds no line to {table}"
    return found[1], found[2]


@pytest.fixture
def added(tmp_path, monkeypatch):
    """A function that puts a file of the page where its module is imported from."""

    def add(place):
        module = place.removesuffix(".py").replace("/", ".")
        package, _, name = module.rpartition(".")
        folder = tmp_path / package
        folder.mkdir(exist_ok=True)
        (folder / f"{name}.py").write_text(block(place), encoding="utf-8")
        __import__(package)
        parent = sys.modules[package]
        monkeypatch.setattr(parent, "__path__", [*parent.__path__, str(folder)])
        monkeypatch.delitem(sys.modules, module, raising=False)
        return module

    yield add
    pages = (
        "study.baselines.prior",
        "measure.gaps.medians",
        "data.readers.flat",
        "maps.projection.widest",
    )
    for name in (f"omnivat.{page}" for page in pages):
        sys.modules.pop(name, None)


@pytest.fixture
def embeddings_file(make_embeddings, tmp_path):
    """A small set of two domains on disk."""
    from omnivat.data.store import save_embeddings

    path = tmp_path / "set.safetensors"
    save_embeddings(path, make_embeddings(per_class=4, split=True))
    return path


@pytest.mark.parametrize(
    ("place", "table", "words"),
    [
        ("study/baselines/prior.py", "BASELINES", "protocol --seeds 0 --methods"),
        ("measure/gaps/medians.py", "GAPS", "gaps --stage raw --measure"),
        ("maps/projection/widest.py", "PROJECTIONS", "project --stage raw --method"),
    ],
)
def test_one_file_and_one_line_are_in_a_command(
    place, table, words, added, monkeypatch, embeddings_file, capsys
):
    from omnivat.cli import main

    package = import_module(added(f"omnivat/{place}").rpartition(".")[0])
    name, target = entry(table)
    monkeypatch.setitem(getattr(package, table), name, target)
    out = embeddings_file.with_name("map.csv" if table == "PROJECTIONS" else "protocol")
    more = ["--out", str(out)] if table != "GAPS" else []
    assert main([*words.split(), name, "--embeddings", str(embeddings_file), *more]) == 0
    assert name in capsys.readouterr().out


def test_a_reader_of_one_file_and_one_line_recognises_its_layout(added, monkeypatch, tmp_path):
    from omnivat.data import readers

    added("omnivat/data/readers/flat.py")
    name, target = entry("READERS")
    monkeypatch.setattr(readers, "READERS", {name: target, **readers.READERS})
    folder = tmp_path / "kitchen"
    folder.mkdir()
    for part in ("photo", "touch"):
        Image.fromarray(np.zeros((8, 8, 3), np.uint8)).save(folder / f"wood-1.{part}.png")
    found = readers.read_pairs(folder)
    assert [(pair.domain, pair.material) for pair in found.pairs] == [("kitchen", "wood")]


def test_a_simulated_sensor_of_one_row_is_drawn(tmp_path):
    from simulator.build import simulate
    from simulator.photograph import plain

    names = {}
    exec(block("simulator/my_domain.py"), names)
    made = simulate(
        tmp_path, domains=[names["BRIGHT"]], pairs_per_class=1, size=32, renderer=plain, workers=1
    )
    assert {(pair.domain, pair.tac.is_file()) for pair in made.pairs} == {
        ("Bright DIGIT-sim", True)
    }


def test_a_tab_of_the_page_is_a_module_with_a_title_and_a_folder_of_scripts():
    names = {}
    exec(block("app/hello/tab.py"), names)
    assert names["TITLE"] == "Hello"
    assert "export async function start(element)" in block("app/web/hello/hello.js")
    assert "<section" in block("app/web/hello/hello.html")
