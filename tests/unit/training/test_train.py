"""Training: it learns, is reproducible, and does not depend on text."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import torch

from omnivat.encoders.lang.bank import load_bank
from omnivat.kit.errors import DataError, OmniVatError
from omnivat.measure.guard import lang_guard
from omnivat.training import TrainSettings
from omnivat.training.batches import batches
from tests.builders import equal_weights

from .conftest import accuracy, learned


@pytest.fixture(scope="module")
def trained(source):
    return learned(source, epochs=8)


def test_a_head_learns_its_source_and_p_stays_near_its_start(source, trained):
    assert accuracy(trained.model, source) > 0.95
    assert trained.epochs[-1]["cross_entropy"] < 0.3 < trained.epochs[0]["cross_entropy"]
    assert abs(trained.model.order - 0.5) < 0.2
    assert trained.model.order != 0.5


def test_same_seed_gives_the_same_weights_to_the_bit(source):
    runs = [learned(source, epochs=1, seed=seed).model for seed in (5, 5, 6)]
    assert equal_weights(*runs[:2]) and not equal_weights(*runs[1:])


def test_lang_leaks_less_than_five_points_into_training(source, trained):
    """With LANG always on, a head reads the class from the text and fails without it."""
    assert lang_guard(trained.model, source, load_bank(), seed=0)["gap"] < 0.05


def test_a_head_of_one_modality_learns_from_it_and_never_reads_the_other(source):
    noise = np.full_like(source.vis, np.nan)
    blind = replace(source, vis=noise, vis_flip=noise)
    models = [learned(some, epochs=6, modalities="tac").model for some in (source, blind)]
    assert equal_weights(*models)
    assert accuracy(models[0], source, modalities=("tac",)) > 0.9


def test_an_order_a_modality_is_learned_apart_and_logged(source):
    trained = learned(source, head={"order_per_modality": True}, epochs=2)
    assert len(set(trained.model.orders.values())) == 3
    assert trained.epochs[-1]["order_vis"] == trained.model.orders["vis"]


@pytest.mark.parametrize(("label", "sentence"), [(0, "one class only"), (99, "no training pairs")])
def test_a_source_of_fewer_than_two_classes_is_refused(source, label, sentence):
    with pytest.raises(DataError, match=sentence):
        learned(source.select(source.label == label))


def test_a_value_that_is_not_finite_is_named_before_training(source):
    bad = source.vis.copy()
    bad[0, 0] = np.inf
    broken = replace(source, vis=bad, vis_flip=None)
    with pytest.raises(OmniVatError, match="inf in row 0, column 0"):
        learned(broken, epochs=1)


def test_a_gradient_that_is_not_finite_stops_although_the_loss_is(source, monkeypatch):
    monkeypatch.setattr(
        torch, "_foreach_norm", lambda tensors: [torch.tensor(torch.inf)] * len(tensors)
    )
    with pytest.raises(OmniVatError, match=r"Training stopped: the loss is \d.*Lower lr"):
        learned(source, epochs=1)


def test_p_moves_by_a_tenth_of_the_rate_a_step_at_most(source):
    """Its gradient is held to 1, its rate is a hundredth, and momentum 0.9 adds up to ten steps."""
    steps = len(source) // 16
    settings = {"epochs": 4, "lr": 0.5, "warmup_epochs": 0.0}
    trained = learned(source, **settings)
    path = [0.5, *(epoch["order"] for epoch in trained.epochs)]
    moved = [abs(after - before) for before, after in itertools.pairwise(path)]
    assert 0 < max(moved) <= 0.1 * 0.5 * steps
    assert max(epoch["order_clipped"] for epoch in trained.epochs) > 0
    wild = learned(source, **settings, order_lr_scale=1.0, order_clip=1e9)
    assert max(abs(epoch["order"] - 0.5) for epoch in wild.epochs) > 0.1 * 0.5 * steps


@pytest.mark.parametrize(
    "change", [{"order": 0.0}, {"order": -2.0}, {"learn_order": False}], ids=str
)
def test_even_orders_are_points_of_rest_as_is_one_that_is_not_learned(source, change):
    """Im is zero there and Re has no slope: p gets no gradient and stays to the bit."""
    trained = learned(source, head=change, epochs=1)
    assert trained.model.order == change.get("order", 0.5)


def test_orders_are_drawn_for_each_pair_from_a_little_more_than_a_quarter_turn(source):
    drawn = list(batches(source, source.label, None, TrainSettings(order_draw=True), 3))
    orders = torch.cat([batch.order for batch in drawn])
    assert len(orders.unique()) == len(source)
    assert -0.1 <= orders.min() < 0 and 1 < orders.max() <= 1.1
