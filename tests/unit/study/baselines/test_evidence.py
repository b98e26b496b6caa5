"""Choices are made on held-out objects of the source."""

from dataclasses import replace

import pytest
import torch

from omnivat.head import linear_maps as maps
from omnivat.study.baselines import linear_maps
from omnivat.study.baselines.contract import COPIES, Fitted, Source
from omnivat.study.baselines.evidence import best, folds


@pytest.fixture
def source():
    random = torch.Generator().manual_seed(0)
    labels = torch.arange(36) % 3
    rows = torch.eye(3).repeat(1, 4)[labels] * 2
    return Source(
        vis=rows + torch.randn(36, 12, generator=random),
        tac=rows + torch.randn(36, 12, generator=random),
        labels=labels,
        objects=tuple(f"{label}/{k // 6}" for k, label in enumerate(labels.tolist())),
        classes=("wood", "steel", "glass"),
    )


def test_folds_keep_objects_whole_and_differ(source):
    found = folds(source)
    assert len(found) == 4
    for rows, held in found:
        assert sorted([*rows.tolist(), *held.tolist()]) == list(range(36))
        assert not {source.objects[i] for i in rows} & {source.objects[i] for i in held}
    assert len({tuple(held.tolist()) for _, held in found}) > 1


def test_the_flipped_copies_of_held_out_objects_are_not_fitted(source):
    flipped = torch.randn(36, 12)
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

    alike = replace(source, labels=torch.zeros(36, dtype=torch.long))
    assert best(alike, shares, fit) == "careful"


def test_noise_reaches_every_drawn_row_and_the_copies_of_a_solved_method(source):
    wide = replace(source, vis=torch.randn(36, 4000) * 3, tac=torch.randn(36, 4000), noise=2.0)
    vis, tac = wide.drawn(torch.arange(36))
    for rows, plain in ((vis, wide.vis), (tac, wide.tac)):
        size = ((rows - plain) / plain.std(0, correction=0)).std()
        assert size == pytest.approx(2.0, rel=0.01)
    full = wide.both_views()
    assert len(full) == len(full.objects) == len(full.vis) == 36 * COPIES
    assert not torch.equal(full.vis[:36], full.vis[36:72])
    assert torch.equal(full.tac, wide.both_views().tac)
    assert full.both_views().vis.shape == full.vis.shape  # noise enters once


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr(maps, "STEPS", 9)
    monkeypatch.setattr(maps, "PLAIN_STEPS", 9)


@pytest.mark.usefixtures("short")
def test_the_chosen_noise_is_told_and_another_seed_keeps_it(source, monkeypatch):
    chosen = linear_maps.fit(source).chosen["training noise"]
    assert chosen in linear_maps.CANDIDATES

    def again(part):
        raise AssertionError("chosen again")

    monkeypatch.setattr(linear_maps, "_chosen", again)
    for noise in linear_maps.CANDIDATES:
        fitted = linear_maps.fit(replace(source, settled=(noise,), seed=1))
        assert fitted.chosen == {"training noise": noise}


@pytest.mark.usefixtures("short")
def test_the_choice_is_made_on_objects_that_the_maps_did_not_see(source, monkeypatch):
    learned = []
    fit = linear_maps._fitted

    def watched(part, noise):
        learned.append(set(part.objects))
        return fit(part, noise)

    monkeypatch.setattr(linear_maps, "_fitted", watched)
    linear_maps.fit(source)
    *choosing, final = learned
    assert final == set(source.objects)
    assert len(choosing) == len(linear_maps.CANDIDATES)
    assert all(part < final for part in choosing)
