"""The Compare tab: heads, methods, and scores from source to target."""

from dataclasses import replace

import numpy as np
import pytest

from app.resources import Resources
from app.views import compare
from omnivat.kit.errors import DataError


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
    same = pair.predicted(two_heads, question | {"head": two_heads.where.head.name})
    assert same["stops"] == pair.predicted(two_heads, question)["stops"]


def test_a_method_is_fitted_on_the_source_and_answers_every_pair(resources):
    got = compare.predictions(resources, {"method": "nearest_mean"})
    embeddings = resources.embeddings()
    right = np.array(got["prediction"]) == embeddings.label
    assert got["source"] == "TAG-sim"
    assert right[embeddings.domain == 0].mean() > 0.9
    assert got["pairs"] <= (embeddings.domain == 0).sum()


def test_a_class_that_a_method_lacks_is_left_out_of_its_score(make_embeddings):
    """As for a head; otherwise a class that both lack would count against one of them."""
    embeddings = make_embeddings()
    known = embeddings.header.classes[:3]
    said = np.where(embeddings.label < 3, embeddings.label, 0)
    found = compare.scores_of(embeddings, known, "TAG-sim", said)
    assert found == {"TAG-sim": 1.0, "OF Real-sim": 1.0, "unseen": 1.0}
    everything = compare.scores_of(embeddings, embeddings.header.classes, "TAG-sim", said)
    assert everything["unseen"] == pytest.approx(3 / 5)


def test_a_method_is_scored_on_pairs_that_it_was_not_fitted_on(resources):
    got = compare.predictions(resources, {"method": "nearest_mean"})["accuracy"]
    assert set(got) == {"unseen", "TAG-sim", "OF Real-sim"}
    assert got["unseen"] == got["OF Real-sim"]


def test_a_method_that_is_no_name_is_refused(resources):
    with pytest.raises(DataError, match="No method is called"):
        compare.predictions(resources, {"method": ["nearest_mean"]})


def test_an_unknown_method_is_refused(resources):
    with pytest.raises(DataError, match="No method is called 'magic'"):
        compare.predictions(resources, {"method": "magic"})


def test_without_records_the_matrix_holds_the_heads_own_row(resources, tmp_path, monkeypatch):
    monkeypatch.setattr(compare, "RECORDS", (tmp_path / "none.jsonl",))
    got = compare.matrix(resources)
    assert got["origin"] == "heads"
    assert [row["source"] for row in got["rows"]] == ["TAG-sim"]
    assert set(got["rows"][0]["cells"]) == {"TAG-sim", "OF Real-sim"}


def test_printed_figures_stand_beside_and_are_marked_not_comparable(resources):
    got = compare.matrix(resources)
    assert got["paper"]["OmniVaT"]["TAG-sim"] == [56.2, 53.7]
    assert "simulated" in got["why"]


def test_records_of_the_protocol_give_means_over_seeds_and_skipped_runs_no_row(resources, tmp_path, monkeypatch):
    from omnivat.study.protocol import records

    shown = records.fingerprint(resources.embeddings())
    file = tmp_path / "protocol.jsonl"
    for seed, accuracy, content in ((0, 0.4, shown), (1, 0.6, shown), (2, 1.0, "another set")):
        scores = {"fused": {"accuracy": accuracy, "macro_f1": accuracy / 2}}
        records.append(
            file,
            {
                "format": "omnivat-run-1",
                "method": "m",
                "label": "M",
                "source": "TAG-sim",
                "seed": seed,
                "fold": None,
                "data": {"fingerprint": content},
                "targets": {"OF Real-sim": {"scores": scores}},
            },
        )
    monkeypatch.setattr(compare, "RECORDS", (file,))
    left_out = {k: v for k, v in records.read(file)[0].items() if k != "targets"}
    records.append(file, {**left_out, "method": "late", "skipped": "It needs images."})
    (row, *others) = compare.matrix(resources)["rows"]
    assert "late" not in [other["method"] for other in others]
    assert row["seeds"] == 2
    assert row["cells"] == {"OF Real-sim": pytest.approx([0.5, 0.25])}


def test_the_projects_own_records_are_of_the_set_that_comes_with_it():
    from omnivat.data.store import load_embeddings
    from omnivat.head.heads import default_embeddings
    from omnivat.study.protocol.records import fingerprint

    runs = compare.protocol_runs(fingerprint(load_embeddings(default_embeddings())))
    rows = compare.protocol_rows(runs)
    assert len({row["source"] for row in rows}) == 8
    assert {row["seeds"] for row in rows} == {3}
    assert {"OmniVaT, D = 512", "DTG alone, D = 512"} <= {row["label"] for row in rows}
    order = compare.ranking(runs)
    means = [one["scores"][0][0] for one in order]
    assert means == sorted(means, reverse=True)
    for one in order:
        cells = [row["cells"] for row in rows if row["label"] == one["label"]]
        unseen = [
            [score for name, (score, _) in own.items() if name != source]
            for own, source in zip(cells, (r["source"] for r in rows if r["label"] == one["label"]), strict=True)
        ]
        mean, low, high = one["scores"][0]
        assert mean == pytest.approx(sum(sum(own) / len(own) for own in unseen) / len(unseen))
        assert low < mean < high
        assert 0 <= one["seeds"] < 0.05
