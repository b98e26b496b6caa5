"""The Compare tab: which heads there are, who answers, and scores from source to target."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.resources import Resources
from app.views import compare
from omnivat.errors import DataError


@pytest.fixture
def two_heads(resources, small_places) -> Resources:
    """Return resources with the same head twice: once as the first, once to compare."""
    return Resources(replace(small_places, compare=(small_places.head,)))


def test_a_compared_head_is_listed_by_the_name_of_its_folder(two_heads):
    first, other = compare.heads(two_heads)
    assert (first["name"], other["name"]) == ("", two_heads.where.head.name)
    assert other["generation"] == "tree"
    assert other["source"] == "TAG-sim"


def test_two_compared_heads_of_one_name_are_told_apart(small_places):
    twice = replace(small_places, compare=(small_places.head, small_places.head))
    assert len(Resources(twice).heads) == 3


def test_a_folder_that_is_no_head_is_listed_with_the_reason(resources, small_places, tmp_path):
    other = Resources(replace(small_places, compare=(tmp_path,)))
    assert "is not a head" in compare.heads(other)[1]["problem"]


def test_a_head_that_is_not_loaded_is_refused_by_name(resources):
    with pytest.raises(DataError, match="No head is called 'ghost'"):
        resources.head_named("ghost")


def test_a_pair_is_asked_of_the_head_that_is_named(two_heads):
    from app.views import pair

    question = {"vis": "row:1", "tac": "row:1"}
    same = pair.answer(two_heads, question | {"head": two_heads.where.head.name})
    assert same["stops"] == pair.answer(two_heads, question)["stops"]


def test_a_method_is_fitted_on_the_source_and_answers_every_pair(resources):
    got = compare.answers(resources, {"method": "nearest_mean"})
    embeddings = resources.embeddings()
    right = np.array(got["prediction"]) == embeddings.label
    assert got["source"] == "TAG-sim"
    assert right[embeddings.domain == 0].mean() > 0.9
    assert got["pairs"] <= (embeddings.domain == 0).sum()


def test_an_unknown_method_is_refused(resources):
    with pytest.raises(DataError, match="No method is called 'magic'"):
        compare.answers(resources, {"method": "magic"})


def test_without_records_the_matrix_holds_the_heads_own_row(resources, tmp_path, monkeypatch):
    monkeypatch.setattr(compare, "RECORDS", tmp_path / "none.json")
    got = compare.matrix(resources)
    assert got["origin"] == "heads"
    assert [row["source"] for row in got["rows"]] == ["TAG-sim"]
    assert set(got["rows"][0]["cells"]) == {"TAG-sim", "OF Real-sim"}


def test_printed_figures_stand_beside_and_are_marked_not_comparable(resources):
    got = compare.matrix(resources)
    assert got["paper"]["OmniVaT"]["TAG-sim"] == [56.2, 53.7]
    assert "simulated" in got["why"]


def test_records_of_the_protocol_give_means_over_seeds(resources, tmp_path, monkeypatch):
    def record(seed: int, accuracy: float, weights: str = "0" * 16) -> dict[str, object]:
        scores = {"fused": {"accuracy": accuracy, "macro_f1": accuracy / 2}}
        return {
            "method": "m",
            "label": "M",
            "source": "TAG-sim",
            "seed": seed,
            "fold": None,
            "data": {"weights_hash": weights},
            "targets": {"OF Real-sim": {"scores": scores}},
        }

    file = tmp_path / "protocol.json"
    file.write_text(json.dumps({"records": [record(0, 0.4), record(1, 0.6), record(2, 1.0, "x")]}))
    monkeypatch.setattr(compare, "RECORDS", file)
    (row, *_) = compare.matrix(resources)["rows"]
    assert row["seeds"] == 2
    assert row["cells"] == {"OF Real-sim": pytest.approx([0.5, 0.25])}


def test_the_projects_own_records_can_be_read_where_they_are():
    if Path(compare.RECORDS).is_file():
        assert isinstance(compare.protocol_rows("6ed769f7314b3a46"), list)
