"""A head for every order learns the mean logits of teachers: heads at one order each."""

from dataclasses import replace

import pytest
import torch

from omnivat.encoders.lang.bank import load_bank
from omnivat.head.head import build_head
from omnivat.head.losses import joint_loss
from omnivat.head.output import TrainingOutput
from omnivat.kit.errors import SettingsError
from omnivat.training import TrainSettings, train
from omnivat.training.batches import batches
from omnivat.training.steps import learn, make_optimiser
from tests.builders import equal_weights, head_settings

from .conftest import accuracy

EVERY = TrainSettings(epochs=8, lang=False, order_draw=True, order_teachers=2)


def made(source, settings, **more):
    return train(source, head_settings(), settings, seed=2, **more)


def test_with_targets_the_loss_is_the_squared_difference_from_them():
    torch.manual_seed(0)
    logits = {name: torch.randn(4, 5) for name in ("vis", "tac")}
    targets = {name: torch.randn(4, 5) for name in ("vis", "tac")}
    layers, labels = [torch.randn(4, 1, 6)], torch.arange(4)
    output = TrainingOutput(features={}, layers=layers, logits=logits, tokens={})
    found = joint_loss(output, labels, nod_weight=0.0, targets=targets)
    wanted = sum((logits[n] - targets[n]).square().mean() for n in logits) / 2
    torch.testing.assert_close(found.total, wanted)
    assert joint_loss(output, labels, targets=logits).total.item() == 0
    torch.testing.assert_close(found.cross_entropy, joint_loss(output, labels).total)


def test_a_taught_head_never_sees_the_labels(source):
    """Given a teacher, other labels change nothing but the reported cross-entropy."""
    settings = TrainSettings(batch=len(source), lang=False)
    (batch,) = batches(source, source.label, None, settings, 0)
    teacher, moved, losses = build_head(head_settings(), seed=1).eval(), [], []
    for labels in (batch.labels, batch.labels.flip(0)):
        model = build_head(head_settings(class_token=False), seed=2).train()
        optimiser = make_optimiser(model, settings)
        losses.append(learn(model, optimiser, replace(batch, labels=labels), settings, [teacher]))
        moved.append(model)
    assert equal_weights(*moved)
    assert losses[0]["loss"] == losses[1]["loss"]
    assert losses[0]["cross_entropy"] != losses[1]["cross_entropy"]


@pytest.mark.long
def test_a_taught_head_predicts_its_source_at_every_order(source):
    model = made(source, replace(EVERY, epochs=100)).model
    for order in (0.0, 0.3, 0.7, 1.0):
        assert accuracy(model, source, order=order) > 0.9


@pytest.fixture
def teachers(monkeypatch):
    """Return what each teacher is made with: its order, its settings and whether it has text. A
    teacher of more than 100 epochs ends the training.
    """
    from omnivat.training import training

    made, start = [], training.train

    def noted(pairs, settings, training, **more):
        made.append((settings.order, training, more["bank"] is not None))
        if training.epochs > 100:
            raise StopIteration
        return start(pairs, settings, training, **more)

    monkeypatch.setattr(training, "train", noted)
    return made


def test_teachers_hold_evenly_spaced_orders_and_only_they_use_lang(source, teachers):
    settings = replace(EVERY, lang=True, epochs=1, order_teachers=3, batch=8, lr=0.01)
    own = train(source, head_settings(), settings, bank=load_bank())
    teacher = TrainSettings(epochs=1)  # with the batch and rate of any teacher
    assert teachers == [(order, teacher, True) for order in (0.0, 0.5, 1.0)]
    assert own.epochs[-1]["mma"] == 0  # the head itself has no text
    assert own.model.order == 0.5


def test_a_teacher_of_a_long_training_learns_for_120_epochs(source, teachers):
    with pytest.raises(StopIteration):
        train(source, head_settings(), replace(EVERY, epochs=200))
    assert teachers == [(0.0, TrainSettings(epochs=120, lang=False), False)]


def test_teachers_without_drawn_orders_are_refused():
    with pytest.raises(SettingsError, match="order_draw"):
        TrainSettings(order_teachers=1)
