"""The frames and sets a visitor may choose, and Explore's facts about the set."""

import json
from base64 import b64decode
from dataclasses import replace

import numpy as np
import pytest

from app.explore import tab as explore
from app.shared.modes import fitting_files, mode_files, modes
from app.shared.resources import Resources
from app.shared.tables import tables
from app.shared.visitor_sets import VisitorSets
from omnivat.maps.frames import read_frames, write_frames

from .conftest import served


@pytest.fixture(scope="module")
def trained(head_folder, tmp_path_factory):
    """Return a folder with the small set and frames that imitate retrained ones."""
    from omnivat.data.store import load_embeddings
    from omnivat.head.checkpoint import load_head
    from omnivat.maps.frames import build_frames

    folder = tmp_path_factory.mktemp("trained")
    made = folder / "set.safetensors"
    made.write_bytes((head_folder.parent / "set.safetensors").read_bytes())
    frames = build_frames(
        load_head(head_folder).model,
        load_embeddings(made),
        orders=(0.0, 0.5, 1.0),
        maps={"pca/raw": 1, "pca/f_hat": 3},
        provenance={"kind": "retrained", "source": "TAG-sim"},
    )
    write_frames(folder / "retrained.bin", frames)
    return folder


@pytest.fixture
def beside(small_places, trained):
    return Resources(replace(small_places, embeddings=trained / "set.safetensors"))


@pytest.fixture
def client(beside):
    return served(beside)


def test_frames_beside_the_set_are_a_mode_of_their_own(beside, client):
    assert modes(beside)["modes"] == ["retrained", "moved"]
    answer = client.get("/omnivat/frames?mode=retrained")
    assert answer.content.startswith(b"OVFRAMES")
    assert answer.headers["X-Holds"] == beside.holds


def test_frames_of_another_set_are_left_out(beside, trained, tmp_path, caplog):
    other = tmp_path / "set.safetensors"
    other.write_bytes(beside.where.embeddings.read_bytes())
    frames = read_frames(trained / "retrained.bin")
    foreign = replace(frames, embeddings={**frames.embeddings, "weights_hash": "else"})
    write_frames(tmp_path / "retrained.bin", foreign)
    (tmp_path / "every.bin").write_bytes(b"OVFRAMES no")
    found = Resources(replace(beside.where, embeddings=other))
    assert set(mode_files(found.where)) == {"retrained", "every"}
    assert fitting_files(found) == {}
    assert "of another set" in caplog.text
    assert modes(found)["modes"] == ["moved"]


def test_a_mode_that_is_not_there_is_refused_in_a_sentence(client):
    for mode in ("every", "..", "x" * 100):
        answer = client.get(f"/omnivat/frames?mode={mode}")
        assert answer.status_code == 404
        assert "no frames of the kind" in answer.json()["error"]


def test_without_embeddings_the_page_still_says_what_may_be_chosen(small_places, tmp_path):
    lost = Resources(replace(small_places, embeddings=tmp_path / "none.safetensors"))
    assert modes(lost)["modes"] == ["moved"]
    assert [modes(lost, among)["twins"] for among in (None, ())] == [True, False]


def test_explore_is_told_what_the_head_does_in_unseen_domains(beside, client):
    found = client.get("/omnivat/unseen").json()
    assert found["source"] == "TAG-sim"
    assert [own["name"] for own in found["domains"]] == ["TAG-sim", "OF Real-sim"]
    cosine, answers = found["pairs"]["cosine"], found["pairs"]["answers"]["fused"]
    assert (cosine["kind"], cosine["steps"]) == ("i2", 10_000)
    assert np.abs(np.frombuffer(b64decode(cosine["data"]), "<i2")).max() <= 10_000
    assert len(b64decode(answers["data"])) == 80  # one byte a pair
    assert explore.unseen(beside) is explore.unseen(beside)  # computed once
    json.dumps(found, allow_nan=False)


@pytest.fixture
def shipped(trained, monkeypatch):
    """Let the folder with the small set be the one set of the project, under the name "chirps"."""
    (trained / "head").mkdir(exist_ok=True)
    for module in ("app.shared.visitor_sets", "app.shared.places", "app.shared.modes"):
        sets = {"chirps": (trained, trained / "set.safetensors")}
        monkeypatch.setattr(f"{module}.shipped_sets", lambda sets=sets: sets)


def test_the_curve_of_a_set_is_that_of_a_mode_with_a_head_for_each_stop(
    beside, shipped, trained, tmp_path, monkeypatch
):
    row = {"id": "frozen", "file": str(tmp_path / "frozen.bin"), "can": ["heads"]}
    monkeypatch.setitem(tables(), "modes", [*tables()["modes"], row])
    frames, share = read_frames(trained / "retrained.bin"), [0.2, 0.5, 0.3]
    curves = {**frames.curves, "seeds:accuracy/unseen/mean": share}
    write_frames(tmp_path / "frozen.bin", replace(frames, curves=curves))
    (found,) = modes(beside)["sets"]
    assert found["curve"] == {"title": "Chirps", "orders": [0, 0.5, 1], "share": share}


def test_a_shipped_set_is_opened_by_its_name_once(beside, shipped, trained):
    sets = VisitorSets(Resources(beside.where))
    other = sets.named("chirps")
    assert other is sets.named("chirps")
    assert other.where.head == trained / "head"
    named = {"name": "chirps", "title": "Chirps", "shown": True, "curve": None}
    assert modes(other)["sets"] == [named]
    same = VisitorSets(Resources(other.where))
    assert same.named("chirps") is same.first
