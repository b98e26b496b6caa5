"""Choices are made on held-out objects of the source."""

from dataclasses import replace

import pytest
import torch

from omnivat.study.baselines.contract import COPIES, Fitted, Source
from omnivat.study.baselines.evidence import best, folds


@pytest.fixture
def source():
    count = 24
    return Source(
        vis=torch.randn(count, 3),
        tac=torch.randn(count, 3),
        labels=torch.arange(count) % 3,
        objects=tuple(f"{i % 3}/{i // 6}" for i in range(count)),
        classes=("wood", "steel", "glass"),
    )


def test_folds_keep_objects_whole_and_differ(source):
    found = folds(source)
    assert len(found) == 4
    for rows, held in found:
        assert sorted([*rows.tolist(), *held.tolist()]) == list(range(24))
        assert not {source.objects[i] for i in rows} & {source.objects[i] for i in held}
    assert len({tuple(held.tolist()) for _, held in found}) > 1


def test_one_candidate_is_taken_without_fitting(source):
    def fit(part, candidate):
        raise AssertionError("fitted for nothing")

    assert best(source, {"only": 1}, fit) == "only"


def test_where_nothing_can_be_held_out_the_first_candidate_is_taken(source):
    one_object_each = source.select(torch.tensor([0, 1, 2]))
    assert best(one_object_each, {"a": 1, "b": 2}, lambda part, c: None) == "a"


def test_the_flipped_copies_of_held_out_objects_are_not_fitted(source):
    flipped = torch.randn(24, 3)
    both = replace(source, vis_flip=flipped, tac_flip=flipped)
    rows, held = folds(both)[0]
    part = both.select(rows).both_views()
    assert len(part) == 2 * len(rows)
    assert not any((part.vis == flipped[i]).all(-1).any() for i in held)


def test_a_low_log_loss_counts_before_right_answers(source):
    """Three of four right but sure of the miss, against two right and never far off."""
    shares = {
        "bold": [[0.6, 0.4]] * 3 + [[1e-6, 1 - 1e-6]],
        "careful": [[0.6, 0.4]] * 2 + [[0.45, 0.55]] * 2,
    }

    def fit(part, candidate):
        def predict(vis, tac):
            return {"fused": torch.tensor(candidate).repeat(-(-len(vis) // 4), 1)[: len(vis)]}

        return Fitted(predict=predict)

    alike = replace(source, labels=torch.zeros(24, dtype=torch.long))
    assert best(alike, shares, fit) == "careful"


def test_what_another_seed_chose_is_not_chosen_again(source):
    settled = replace(source, settled=("C of another method", "b"))

    def fit(part, choice):
        raise AssertionError("nothing is fitted")

    assert best(settled, {"a": 1, "b": 2}, fit) == "b"


def test_noise_reaches_every_drawn_row_and_the_copies_of_a_solved_method(source):
    wide = replace(source, vis=torch.randn(24, 4000) * 3, tac=torch.randn(24, 4000), noise=2.0)
    vis, tac = wide.drawn(torch.arange(24))
    for rows, plain in ((vis, wide.vis), (tac, wide.tac)):
        size = ((rows - plain) / plain.std(0, correction=0)).std()
        assert size == pytest.approx(2.0, rel=0.03)
    full = wide.both_views()
    assert len(full) == len(full.objects) == len(full.vis) == 24 * COPIES
    assert not torch.equal(full.vis[:24], full.vis[24:48])
    assert torch.equal(full.tac, wide.both_views().tac)
    assert full.both_views().vis.shape == full.vis.shape  # noise enters once
