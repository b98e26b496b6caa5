"""Heads and sets loaded through the page: checked, and visible to their visitor only."""

import numpy as np
import pytest
from starlette.requests import Request

from app.shared.limits import PARTS
from app.shared.requests import visitor_of
from app.shared.state import ForgottenError
from app.shared.visitor_sets import VisitorSets
from omnivat.data.store import load_embeddings, save_embeddings
from omnivat.kit.errors import DataError

from .conftest import loaded, sentence


def head_files(folder):
    return {
        name: folder / name for name in ("weights.safetensors", "settings.json", "metrics.json")
    }


def test_a_head_without_weights_is_refused_in_a_sentence(client, small_places):
    got = loaded(client, {"settings.json": small_places.head / "settings.json"})
    assert sentence(got) == "A head also has weights.safetensors; choose its whole folder."


def test_a_set_without_pairs_is_refused(client, small_places, tmp_path):
    pairs = load_embeddings(small_places.embeddings)
    save_embeddings(tmp_path / "set.safetensors", pairs.select(np.zeros(0, np.int64)))
    got = loaded(client, {"embeddings.safetensors": tmp_path / "set.safetensors"})
    assert "'embeddings.safetensors' holds no pairs" in sentence(got)


@pytest.mark.parametrize("name", ["../x", ""])
def test_a_file_of_another_name_is_refused(client, name):
    got = client.post("/omnivat/part", params={"name": name}, content=b"x")
    assert "is no file of a head or set" in sentence(got)


@pytest.mark.parametrize("parts", [None, {"settings.json": "../../x"}])
def test_junk_that_names_parts_is_refused(client, parts):
    assert client.post("/omnivat/load", json={"parts": parts}).status_code == 400


def keep(sets, tmp_path, name, content):
    """Keep a file of a head or set; return its name."""
    file = tmp_path / "sent"
    file.write_bytes(content)
    return sets.take_part(sets.first, file, {"name": name})["part"]


def test_a_file_that_is_too_large_is_refused_and_removed(resources, tmp_path):
    sets, name = VisitorSets(resources), "embeddings.thumbnails.json"
    with pytest.raises(DataError, match="is larger than 0.1 MB"):
        keep(sets, tmp_path, name, b"x" * (PARTS[name] + 1))
    assert list(sets.shared.scratch.folder("parts").iterdir()) == []


@pytest.fixture
def load_one(tmp_path, small_places):
    """Return a function that loads a head which differs in its last file."""

    def load(sets, number, beside="", compare=False):
        parts = {}
        for name, file in head_files(small_places.head).items():
            content = file.read_bytes() + b" " * (number if name == "metrics.json" else 0)
            parts[name] = keep(sets, tmp_path, name, content)
        return sets.load(sets.named(beside), {"parts": parts, "compare": compare})["set"]

    return load


def test_ten_heads_are_compared_and_a_load_never_reports_a_set_that_is_gone(
    resources, small_places, monkeypatch, tmp_path, load_one
):
    monkeypatch.setattr("app.shared.visitor_sets.KEPT_DESKS", 3)
    sets, file = VisitorSets(resources), "embeddings.safetensors"
    pairs = keep(sets, tmp_path, file, small_places.embeddings.read_bytes())
    name = sets.load(sets.first, {"parts": {file: pairs}})["set"]
    for number in range(10):
        name = load_one(sets, number, beside=name, compare=True)
        assert len(sets.named(name).heads) == number + 2
    assert len(sets.named(name).embeddings()) == 80
    homes = {path.parent for path in (sets.named(name).where.embeddings,)}
    homes |= {path.parent for path in sets.named(name).where.compare}
    assert len(homes) == 1  # it needs no other set's folder
    assert load_one(sets, 0) != name
    assert len(sets.named(name).heads) == 11


def test_files_that_are_not_loaded_are_bounded_and_the_oldest_go_first(
    resources, monkeypatch, tmp_path, load_one
):
    monkeypatch.setattr("app.shared.visitor_sets.KEPT_PARTS", 5)
    monkeypatch.setattr("app.shared.visitor_sets.PARTS_BYTES", 10)
    sets = VisitorSets(resources)
    sent = [keep(sets, tmp_path, "settings.json", str(number).encode()) for number in range(40)]
    there = {file.name for file in sets.shared.scratch.folder("parts").iterdir()}
    assert there == set(sent[-5:])
    keep(sets, tmp_path, "settings.json", b"123456789")
    assert len(list(sets.shared.scratch.folder("parts").iterdir())) == 1
    monkeypatch.undo()
    assert load_one(VisitorSets(resources), 0)


@pytest.mark.parametrize(
    ("host", "visitor"),
    [
        ("10.0.0.7", "10.0.0.7"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("fe80::1%eth0", "fe80::/64"),
        ("::ffff:10.0.0.7", "10.0.0.7"),
        ("testclient", "testclient"),
    ],
)
def test_a_visitor_is_an_address_or_the_network_that_one_visitor_has(host, visitor):
    assert visitor_of(Request({"type": "http", "client": (host, 5)})) == visitor


def test_the_desk_unused_for_longest_is_forgotten_with_its_files(resources, monkeypatch, load_one):
    monkeypatch.setattr("app.shared.visitor_sets.KEPT_DESKS", KEPT_DESKS := 3)
    sets = VisitorSets(resources)
    names = [load_one(sets, number) for number in range(KEPT_DESKS + 1)]
    with pytest.raises(ForgottenError):
        sets.named(names[0])
    assert sets.named(names[-1]).head().source == "TAG-sim"
    assert sum(1 for f in sets.shared.scratch.home.iterdir() if f.is_dir()) == KEPT_DESKS + 1
