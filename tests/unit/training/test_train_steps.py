"""One step of training: its rate, its pairs, its groups of parameters, its batches and its
records.
"""

import sys
from dataclasses import replace

import numpy as np
import pytest
import torch

from omnivat.encoders.lang.bank import load_bank
from omnivat.head.head import build_head
from omnivat.kit.errors import DataError
from omnivat.training import TrainSettings, Watch, train
from omnivat.training.batches import Batch, batches, labels_of
from omnivat.training.steps import Momentum, learn, make_optimiser, pairs_of, set_rate
from tests.builders import CLASSES, head_settings

from .conftest import learned


def batch_of(lang_on, text=True):
    count = len(lang_on)
    torch.manual_seed(0)
    return Batch(
        images={name: torch.randn(count, 24) for name in ("vis", "tac")},
        lang=torch.randn(count, 384) if text else None,
        labels=torch.arange(count) % 5,
        lang_on=torch.tensor(lang_on),
        token_on=torch.ones(count, dtype=torch.bool),
    )


@pytest.mark.parametrize(
    ("epochs", "epoch", "share"),
    [
        *((6, 0.0, 0.05), (6, 2.0, 1.0), (6, 5.0, 0.146447)),
        (1, 0.5, 0.6),  # a warm-up is no longer than the training
    ],
)
def test_the_rate_warms_up_by_step_and_then_follows_a_cosine_to_zero(epochs, epoch, share):
    """Two warm epochs, a step of a tenth of an epoch, which the warm-up counts as done."""
    model = build_head(head_settings())
    settings = TrainSettings(epochs=epochs, warmup_epochs=2.0, lr=0.5)
    optimiser = make_optimiser(model, settings)
    set_rate(optimiser, settings, epoch, 0.1)
    wanted = [0.5 * share, 0.5 * share, 0.005 * share]
    assert [group["lr"] for group in optimiser.param_groups] == pytest.approx(wanted, abs=1e-6)


def test_steps_have_momentum_and_decay_and_need_no_compiler_of_torch(monkeypatch):
    monkeypatch.setitem(sys.modules, "torch._dynamo", None)  # an import of it would fail
    ours, wanted, speed = torch.nn.Parameter(torch.arange(5.0)), torch.arange(5.0), 0.0
    optimiser = Momentum([{"params": [ours], "lr": 0.1, "weight_decay": 0.03}], 0.9)
    for _ in range(3):
        ours.grad = torch.cos(ours.detach())
        optimiser.step()
        speed = 0.9 * speed + torch.cos(wanted) + 0.03 * wanted
        wanted = wanted - 0.1 * speed
        torch.testing.assert_close(ours.detach(), wanted)


def test_weights_decay_but_theta_and_the_order_do_not():
    model, settings = build_head(head_settings()), TrainSettings(weight_decay=0.03)
    optimiser = make_optimiser(model, settings)
    rest, theta, order = optimiser.param_groups
    assert [group["weight_decay"] for group in (rest, theta, order)] == [0.03, 0.0, 0.0]
    assert [len(group["params"]) for group in (theta, order)] == [3, 1]
    assert [group["scale"] for group in (rest, theta, order)] == [1.0, 1.0, 0.01]
    assert optimiser.momentum == 0.9


@pytest.mark.parametrize(
    ("kind", "lang_on", "text", "wanted"),
    [
        ("guided", [True, False, True], True, [True, False, True]),
        ("unguided", [True, False, True], True, [False, True, False]),
        ("all", [True, False, True], True, None),
        ("guided", [True, False, True], False, None),
        ("unguided", [True, True, True], True, None),
    ],
)
def test_the_pairs_of_a_kind_are_those_or_all(kind, lang_on, text, wanted):
    found = pairs_of(kind, batch_of(lang_on, text))
    assert (None if found is None else found.tolist()) == wanted


def gradients(clip, order_clip=1e12):
    """Return what a step from one start moves, without momentum and decay, and its record."""
    model, batch = build_head(head_settings(), seed=1), batch_of([True, False, True, False])
    settings = TrainSettings(
        clip=clip,
        order_clip=order_clip,
        momentum=0.0,
        weight_decay=0.0,
        warmup_epochs=0.0,
        order_lr_scale=1.0,
    )
    optimiser = make_optimiser(model, settings)
    for group in optimiser.param_groups:
        group["lr"] = 1e-3
    before = {name: p.detach().clone() for name, p in model.named_parameters()}
    record = learn(model, optimiser, batch, settings)
    moved = {name: (p.detach() - before[name]).double() for name, p in model.named_parameters()}
    order = float(moved.pop("mffa.order"))
    return (
        float(torch.stack([m.square().sum() for m in moved.values()]).sum().sqrt()),
        order,
        record,
    )


def test_a_gradient_is_scaled_to_the_limit_of_its_norm_and_the_order_by_value():
    free, order, record = gradients(1e6)
    assert (record["clipped"], record["order_clipped"]) == (0, 0)
    short, same, record = gradients(0.25 * free / 1e-3)
    assert record["clipped"] == 1 and short == pytest.approx(0.25 * free, rel=1e-3)
    assert same == pytest.approx(order)
    _, held, record = gradients(1e6, 0.5 * abs(order) / 1e-3)
    assert record["order_clipped"] == 1 and held == pytest.approx(0.5 * order, rel=1e-3)


def test_a_record_has_the_mean_losses_of_its_epoch(source):
    """Without weight on either, the loss is the cross-entropy; steps count equally."""
    trained = learned(source, epochs=2, mma_weight=0.0, nod_weight=0.0)
    for number, record in enumerate(trained.epochs):
        assert record["epoch"] == number and record["loss"] == pytest.approx(
            record["cross_entropy"]
        )
        assert 0.3 < record["loss"] < 3


def test_a_step_has_the_rate_of_its_place_and_a_report_names_epoch_and_loss(source, monkeypatch):
    from omnivat.training import training

    seen, rates = [], []
    monkeypatch.setattr(training, "set_rate", lambda *given: rates.append(given[2:]))
    train(
        source,
        head_settings(),
        TrainSettings(epochs=2),
        bank=load_bank(),
        watch=Watch(on_step=seen.append),
    )
    assert [one.text.split(", ")[0] for one in seen] == ["epoch 1 of 2"] * 5 + ["epoch 2 of 2"] * 5
    np.testing.assert_allclose(rates, [(k / 5, 1 / 5) for k in range(10)])
    part = Watch(on_step=seen.append).part(7, 100)
    part.step(3, 10, "x")
    assert (seen[-1].done, seen[-1].total) == (10, 100)


def test_a_class_that_the_head_lacks_is_named(source):
    with pytest.raises(DataError, match="pairs of 'glass', which the head lacks"):
        labels_of(source, head_settings(classes=CLASSES[:4]))
    assert set(labels_of(source.select(source.label < 2), head_settings())) == {
        0,
        1,
    }  # two are enough


def test_each_pair_is_mirrored_half_the_time_and_has_a_style_of_its_class(source):
    bank, settings = load_bank(), TrainSettings(batch=len(source))
    flipped = replace(source, vis_flip=source.vis + 100, tac_flip=source.tac + 100)
    mirrored, dropped, styles = [], [], set()
    for seed in range(20):
        (batch,) = batches(flipped, source.label, bank, settings, seed)
        mirrored.append(float((batch.images["vis"].mean(1) > 50).double().mean()))
        dropped.append(
            (float(batch.lang_on.double().mean()), float(batch.token_on.double().mean()))
        )
        for text, label in zip(batch.lang.numpy(), batch.labels.tolist(), strict=True):
            (place,) = np.flatnonzero((bank.embeddings[label] == text).all(1))[:1]
            styles.add(int(place))
    assert np.mean(mirrored) == pytest.approx(0.5, abs=0.05)
    assert np.mean(dropped, axis=0) == pytest.approx([0.5, 0.5], abs=0.05)
    assert styles == set(range(bank.embeddings.shape[1]))


def test_a_search_lowers_the_rate_of_the_order_to_a_tenth(source, monkeypatch):
    from omnivat.training import training

    made, start = [], training.make_optimiser
    monkeypatch.setattr(training, "make_optimiser", lambda *a: (made.append(a), start(*a))[1])
    trained = learned(source, head={"order": -3.0}, epochs=1, lang=False, order_search=True)
    ((model, used),) = made
    assert model.settings.order == trained.search["start"]
    assert used.order_lr_scale == pytest.approx(0.001)
    assert trained.search["found"] == trained.model.order != trained.search["start"]


def test_a_step_takes_the_orders_of_its_batch_and_unguided_pairs_for_the_bank(monkeypatch):
    settings, batch, losses, moved = TrainSettings(), batch_of([True, False, True]), [], []
    for order in (0.1, 0.9):
        model = build_head(head_settings(), seed=1)
        monkeypatch.setattr(model.mffa, "update_bank", lambda _, labels: moved.extend(labels))
        drawn = replace(batch, order=torch.full((3,), order, dtype=torch.float64))
        losses.append(learn(model, make_optimiser(model, settings), drawn, settings)["loss"])
    assert losses[0] != losses[1] and moved == [1, 1]
