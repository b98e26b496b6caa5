"""The ladder: rungs of a loaded head, and rungs from records."""

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnivat.data.profile import profile_of
from omnivat.data.store import save_embeddings
from omnivat.head.checkpoint import load_head, save_head
from omnivat.head.heads import EXAMPLES, default_embeddings, default_head, kept_ladder
from omnivat.measure import ladder
from omnivat.measure.known import measured
from omnivat.measure.ladder import FORMAT, METHOD, lettered, letters, recorded, rungs, write_ladder
from omnivat.measure.rungs import RUNGS


@pytest.fixture(autouse=True)
def no_records(monkeypatch, tmp_path):
    monkeypatch.setattr(ladder, "LADDERS", tmp_path / "none.jsonl.gz")
    monkeypatch.setattr(ladder, "measured", partial(measured, draws=3))
    ladder._records.cache_clear()
    yield
    ladder._records.cache_clear()


def test_an_offset_is_mended_rung_by_rung(head, shifted):
    found = {one["rung"]: one for one in rungs(head, shifted)}
    known = [row["id"] for row in RUNGS if row.get("pairs") or row.get("labels")]
    assert list(found) == ["home", "none", *known]
    assert found["none"]["accuracy"] < 0.9 * found["home"]["accuracy"]
    assert found["none"]["accuracy"] < found["n5"]["accuracy"] <= found["all"]["accuracy"] + 0.05
    assert found["all"]["accuracy"] > 0.8 * found["home"]["accuracy"]
    for one in found.values():
        assert 0 <= one["low"] <= one["accuracy"] + 1e-9 <= one["high"] + 2e-9 <= 1 + 3e-9
        assert one["from"] == "this head" and one["source"] == "TAG-sim"


def test_a_head_without_a_profile_has_two_rungs(head, shifted):
    older = replace(head, profile=None)
    assert [one["rung"] for one in rungs(older, shifted)] == ["home", "none"]


@given(st.lists(st.integers(-1, 25)))
def test_letters_come_back(labels):
    assert letters(lettered(np.array(labels, dtype=np.int64))).tolist() == labels


def test_another_source_and_other_rungs_come_from_the_records(head, shifted, tmp_path, monkeypatch):
    file = tmp_path / "ladder.jsonl"
    names = list(shifted.header.domains)
    first = {"domains": names, "classes": ["a", "b"], "domain": [0, 0, 1, 1], "truth": "abab"}
    answers = {"home": "..ab", "none": "aa..", "m2": "ab.."}
    one = {"method": METHOD, "source": names[1], "seed": 0, "answers": answers}
    lines = [first, one, {**one, "source": names[0], "answers": {"m2": "..aa", "none": "..bb"}}]
    file.write_text("".join(json.dumps({"format": FORMAT, **line}) + "\n" for line in lines))
    monkeypatch.setattr(ladder, "LADDERS", file)
    ladder._records.cache_clear()

    other = {r["rung"]: (r["accuracy"], r["from"]) for r in rungs(head, shifted, source=names[1])}
    assert other == {"home": (1.0, "records"), "none": (0.5, "records"), "m2": (1.0, "records")}
    own = {r["rung"]: r["from"] for r in rungs(head, shifted)}
    assert own["m2"] == "records" and own["none"] == own["k1"] == "this head"
    assert recorded("nowhere", names) == []


def test_predictions_of_rungs_are_those_of_profiled_embeddings(head, shifted):
    train = shifted.rows_of("OF Real-sim", split="train")
    near = head.profiled(shifted, [profile_of(shifted, train, domain="OF Real-sim")])
    found = {one["rung"]: one["accuracy"] for one in rungs(head, shifted)}
    assert found["all"] == pytest.approx(measured(head, near)["accuracy"])


def test_a_kept_ladder_is_of_exactly_its_head_and_its_set(head, shifted, tmp_path):
    saved = load_head(save_head(tmp_path / "head", head))
    place = tmp_path / "set.safetensors"
    save_embeddings(place, shifted)
    assert kept_ladder(tmp_path / "head", place) is None
    write_ladder(saved, shifted, place)
    kept = kept_ladder(tmp_path / "head", place)
    assert kept == ladder.ladder(saved, shifted)
    save_embeddings(place, shifted.select(np.arange(len(shifted) - 1)))
    assert kept_ladder(tmp_path / "head", place) is None
    save_embeddings(place, shifted)
    assert kept_ladder(tmp_path / "head", place) == kept
    shorter = replace(head.source_profile, step=0.5)
    save_head(tmp_path / "head", replace(head, profile=shorter))
    assert kept_ladder(tmp_path / "head", place) is None
    save_head(tmp_path / "head", replace(head, provenance={**head.provenance, "seed": 9}))
    assert kept_ladder(tmp_path / "head", place) is None


def test_the_page_has_the_ladder_of_the_shipped_head_without_computing():
    kept = kept_ladder(default_head(), default_embeddings())
    assert kept, "head, set or records are new: run `python -m omnivat evaluate --ladder`"
    maps = json.loads((EXAMPLES / "twins.map.json").read_bytes())
    of_twins = {row["id"]: row["map"] for row in RUNGS if "map" in row}
    assert list(of_twins.values()) == list(range(len(maps["umap"])))
    climbed = [row for row in RUNGS if row["id"] not in ("mean", "spread", "p")]
    assert [one["rung"] for one in kept["rungs"]] == [row["id"] for row in climbed]
    words = [one["known"].partition(" (")[0] for one in kept["rungs"]]  # (of another method)
    assert words == [row["words"] for row in climbed]
