"""One measurement: what is known is drawn, left out of the test, and averaged."""

import numpy as np
import pytest

from omnivat.kit.errors import DataError
from omnivat.measure.known import evaluate, measured, parts, record, target_mean, target_scores
from omnivat.measure.rungs import NOTHING, labels, pairs


def test_nothing_known_is_what_evaluate_says(head, shifted):
    found = measured(head, shifted)
    assert found["accuracy"] == pytest.approx(target_mean(target_scores(evaluate(head, shifted))))
    assert (found["rung"], found["draws"]) == ("none", [found["accuracy"]])
    assert found["low"] < found["accuracy"] < found["high"]


def test_an_evaluation_reports_the_pairs_of_each_domain(head, shifted):
    steps = []
    evaluate(head, shifted, on_step=steps.append)
    assert [(one.done, one.total) for one in steps] == [(120, 240), (240, 240)]
    assert [one.text for one in steps] == ["TAG-sim", "OF Real-sim"]


def test_pictures_and_labels_bring_a_shifted_sensor_back(head, shifted):
    steps = [
        measured(head, shifted, what, draws=3) for what in (NOTHING, pairs(5), pairs(50), labels(3))
    ]
    nothing, few, many, labelled = (step["accuracy"] for step in steps)
    assert nothing < few < many + 0.05 and labelled > nothing + 0.2
    assert [len(step["draws"]) for step in steps] == [1, 3, 3, 3]
    assert steps[1]["accuracy"] == pytest.approx(np.mean(steps[1]["draws"]))


def test_a_known_pair_is_never_tested(head, make_embeddings):
    whole = make_embeddings(per_class=8)  # without a split all pairs are test pairs
    there = (whole.domain == 1).sum()
    home, away = parts(head, whole, pairs(5), seed=3)
    assert (home.known_pairs, away.known_pairs, len(away.rows)) == (0, 5, there - 5)
    assert measured(head, whole, draws=1)["pairs"] == there
    assert measured(head, whole, pairs(5), draws=1)["pairs"] == there - 5
    assert measured(head, whole, labels(2), draws=1)["pairs"] == there - 10


def test_the_source_is_measured_where_asked_and_alone(head, shifted):
    found = measured(head, shifted, home=True)
    assert set(found["domains"]) == {"TAG-sim"}
    assert found["accuracy"] > measured(head, shifted)["accuracy"]


def test_a_domain_counts_once_however_many_pairs_it_has():
    right = np.array([[1.0] * 8 + [0.0] * 2])
    found = record(right, np.array([0] * 8 + [1] * 2), ["a", "b"])
    assert (found["accuracy"], found["domains"]) == (0.5, {"a": 1.0, "b": 0.0})


def test_draws_that_tested_other_pairs_are_averaged_pair_by_pair():
    right = np.array([[1.0, np.nan], [0.0, 1.0]])
    found = record(right, np.array([0, 0]), ["a"])
    assert found["domains"]["a"] == 0.75 and found["draws"] == [1.0, 0.5]


def test_the_source_alone_leaves_nothing_to_measure(head, shifted):
    with pytest.raises(DataError, match="No test pair of any other domain is of a class"):
        measured(head, shifted.in_domain("TAG-sim"))


def test_what_cannot_be_measured_has_its_reason(head, make_embeddings):
    other = make_embeddings(per_class=4, classes=("cork", "felt"))
    with pytest.raises(DataError, match="is of a class that the head learned: wood, steel"):
        measured(head, other)
    with pytest.raises(DataError, match="No test pair of 'TAG-sim', which needs a split"):
        measured(head, make_embeddings(per_class=4), home=True)


def test_seeds_draw_other_pairs(head, make_embeddings):
    whole = make_embeddings(per_class=8)  # without a split: a drawn pair is missing from the test
    first, again, other = (
        [part.places.tolist() for part in parts(head, whole, pairs(2), seed=seed)]
        for seed in (0, 0, 1)
    )
    assert first == again != other
    assert first[0] == other[0]  # the source


def test_an_evaluation_averages_draws_and_keeps_the_source(head, shifted):
    home, away = evaluate(head, shifted, labels(2), draws=2, seed=3)
    single = [evaluate(head, shifted, labels(2), draws=1, seed=seed)[1] for seed in (3, 4)]
    each = [record["scores"]["fused"]["accuracy"] for record in single]
    assert away["draws"] == each and away["known_pairs"] == 10
    assert away["scores"]["fused"]["accuracy"] == pytest.approx(np.mean(each))
    assert home == evaluate(head, shifted)[0] and home["known_pairs"] == 0
