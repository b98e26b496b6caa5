"""One measurement: what is known is drawn, left out of the test, and averaged."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from omnivat.head.linear_maps import fit_maps
from omnivat.kit.errors import DataError
from omnivat.measure.known import at_home, few, measured, parts
from omnivat.measure.readers import Reader, of_head, of_maps
from omnivat.measure.rungs import NOTHING, labels, pairs, sensors
from omnivat.measure.shares import record, wilson


def test_a_measurement_has_both_images_each_image_and_each_domain(head, shifted):
    found = measured(head, shifted)
    home, away = found["domains"]
    assert (home["is_source"], away["is_source"], away["domain"]) == (True, False, "OF Real-sim")
    assert found["accuracy"] == away["scores"]["fused"]["accuracy"] == found["draws"][0]
    assert found["low"] < found["accuracy"] < found["high"]
    assert set(found["scores"]) == {"fused", "vis", "tac", "vis_branch", "tac_branch"}
    counts = np.array(away["confusion"])
    assert counts.sum() == away["pairs"] == found["pairs"] == 2 * away["objects"]
    assert np.trace(counts) / counts.sum() == pytest.approx(found["accuracy"])


@pytest.mark.parametrize("known", [NOTHING, labels(2)], ids=lambda known: known.name)
def test_intervals_count_objects_whatever_is_known(head, shifted, known):
    """Pairs of one object are alike: many pictures of it are no more evidence than one."""
    named = [[""] * 240, [f"o{k // 4}" for k in range(240)]]
    single, several = (
        measured(head, replace(shifted, rows=shifted.rows | {"object": names}), known, draws=2)
        for names in named
    )
    assert single["accuracy"] == several["accuracy"]
    away = several["domains"][1]
    assert away["objects"] * 2 <= away["pairs"]
    right = round(away["scores"]["fused"]["accuracy"] * away["pairs"])
    wanted = wilson(right * away["objects"] / away["pairs"], away["objects"])
    assert (several["low"], several["high"]) == pytest.approx(wanted)
    assert several["high"] - several["low"] > 1.2 * (single["high"] - single["low"])


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
    home, away = parts(of_head(head), whole, pairs(5), seed=3)
    assert (home.known_pairs, away.known_pairs, len(away.rows)) == (0, 5, there - 5)
    assert measured(head, whole, draws=1)["pairs"] == there
    assert measured(head, whole, pairs(5), draws=1)["pairs"] == there - 5
    assert measured(head, whole, labels(2), draws=1)["pairs"] == there - 10


def test_a_domain_counts_once_however_many_pairs_it_has():
    right = np.array([[1.0] * 8 + [0.0] * 2])
    found = record(right, np.array([0] * 8 + [1] * 2), ["a", "b"])
    assert (found["accuracy"], found["domains"]) == (0.5, {"a": 1.0, "b": 0.0})


def test_draws_that_tested_other_pairs_are_averaged_pair_by_pair():
    right = np.array([[1.0, np.nan], [0.0, 1.0]])
    found = record(right, np.array([0, 0]), ["a"])
    assert found["domains"]["a"] == 0.75 and found["draws"] == [1.0, 0.5]


def test_what_cannot_be_measured_is_none(head, shifted, make_embeddings):
    alone = measured(head, shifted.in_domain("TAG-sim"))
    assert (alone["accuracy"], alone["low"], alone["draws"]) == (None, None, [])
    other = make_embeddings(per_class=4, classes=("cork", "felt"))
    assert [one["left_out"] for one in measured(head, other)["domains"]] == [8, 8]
    whole = measured(head, make_embeddings(per_class=4))  # without a split
    assert whole["domains"][0]["trained_on"] and at_home(whole)["accuracy"] is None


@pytest.mark.parametrize("odd", [-1, 1.5, "x", None])
def test_what_is_no_number_of_pairs_is_refused(odd):
    for known in (pairs, labels):
        with pytest.raises(DataError, match=f"{odd!r} .* cannot be known; choose a whole number"):
            known(odd)


def test_seeds_draw_other_pairs(head, make_embeddings):
    whole = make_embeddings(per_class=8)  # without a split: a drawn pair is missing from the test
    first, again, other = (
        [part.rows.tolist() for part in parts(of_head(head), whole, pairs(2), seed=seed)]
        for seed in (0, 0, 1)
    )
    assert first == again != other
    assert first[0] == other[0]  # the source


def test_few_are_half_of_the_smallest_target_at_most(shifted):
    assert few(shifted, "TAG-sim").pairs == 20
    smaller = shifted.select(np.r_[0:120, 120:129])
    assert few(smaller, "TAG-sim") == pairs(4) and few(smaller, "OF Real-sim").pairs == 20
    with pytest.raises(DataError, match="'OF Real-sim' has one pair, .* add a second one"):
        few(shifted.select(np.arange(121)), "TAG-sim")


@pytest.fixture(scope="module")
def maps():
    """Return a function that fits linear maps to training pairs of domains, as a reader."""

    def fitted(embeddings, domains):
        rows = np.concatenate([embeddings.rows_of(name, split="train") for name in domains])
        raw = {n: torch.from_numpy(getattr(embeddings, n)[rows]) for n in ("vis", "tac")}
        classes = len(embeddings.header.classes)
        found = fit_maps(raw, torch.from_numpy(embeddings.label[rows]), classes, steps=30)
        reader = of_maps(found, embeddings.header, source=domains[0])
        return replace(reader, learned=fitted)

    return fitted


def test_more_sensors_are_learned_and_neither_is_the_target(maps, make_embeddings):
    names = ("A", "B", "C", "D")
    several = make_embeddings(domains=names, per_class=8, split=True)
    learned = []

    def noted(embeddings, domains):
        learned.append(tuple(domains))
        return maps(embeddings, domains)

    reader = replace(maps(several, ["A"]), learned=noted)
    for known in (sensors(3), sensors(3, profiles=True)):
        learned.clear()
        found = measured(reader, several, known, draws=2)
        assert len(found["draws"]) == 2 and found["known"].startswith("3 source domains")
        for target, domains in zip("BCDBCD", learned, strict=True):
            assert domains[0] == "A" and len(set(domains)) == 3 and target not in domains
    assert len(set(learned)) > 3  # draws choose others


def test_a_head_of_one_sensor_says_that_it_cannot_learn_more(head, shifted):
    with pytest.raises(DataError, match="cannot learn several domains"):
        measured(head, shifted, sensors(2))


def test_with_a_rest_picture_the_same_pairs_are_read_from_other_embeddings(head, shifted):
    offset = shifted.tac[shifted.domain == 1].mean(0) - shifted.tac[shifted.domain == 0].mean(0)
    subtracted = replace(shifted, tac=shifted.tac - (shifted.domain == 1)[:, None] * offset)
    found = measured(head, shifted, replace(NOTHING, rested=subtracted))
    assert found["scores"] == measured(head, subtracted)["scores"]
    assert found["scores"]["tac"]["accuracy"] > measured(head, shifted)["scores"]["tac"]["accuracy"]


def test_a_pair_without_a_class_is_not_tested(maps, make_embeddings, without_classes):
    some = without_classes(make_embeddings(per_class=8), 2)
    reader = maps(some, ["TAG-sim"])
    assert isinstance(reader, Reader)
    away = measured(reader, some)["domains"][1]
    assert away["left_out"] == 16 and away["pairs"] == 24


def test_f1_is_the_mean_over_draws(head, shifted):
    mean, *each = (
        measured(head, shifted, pairs(2), draws=draws, seed=seed)["domains"][1]["scores"]["fused"]
        for draws, seed in ((2, 3), (1, 3), (1, 4))
    )
    first, second = (one["macro_f1"] for one in each)
    assert first != second and mean["macro_f1"] == pytest.approx((first + second) / 2)
