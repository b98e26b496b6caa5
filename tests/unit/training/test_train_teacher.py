"""A head for every order learns the mean logits of teachers: heads at one order each."""

from dataclasses import replace

import pytest
import torch

from omnivat.head.losses import joint_loss
from omnivat.head.output import TrainingOutput
from omnivat.kit.errors import SettingsError
from omnivat.measure.evaluate import predicted_probabilities
from omnivat.training import TrainSettings, train
from omnivat.training.training import Watch

from .conftest import equal_weights, head

EVERY = TrainSettings(epochs=8, lang=False, order_draw="row", order_teachers=2)


def made(source, settings, **more):
    return train(source, head(), settings, seed=2, **more)


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
    """Given a teacher, wrong labels change nothing but the reported cross-entropy."""
    from omnivat.training import loop

    teacher = made(source, replace(EVERY, order_draw="none", order_teachers=0)).model
    shuffled = replace(source, label=source.label[::-1].copy())
    settings = replace(EVERY, epochs=2)
    plain = head(class_token=False, learn_order=False)
    first, second = (
        loop.train_once(
            pairs,
            plain,
            settings,
            bank=None,
            seed=2,
            resume=None,
            watch=Watch(),
            teachers=[teacher],
        ).model.state_dict()
        for pairs in (source, shuffled)
    )
    assert all(torch.equal(first[name], second[name]) for name in first if "bank" not in name)


@pytest.mark.long
def test_a_taught_head_predicts_its_source_at_every_order(source):
    model = made(source, replace(EVERY, epochs=100)).model
    for order in (0.0, 0.3, 0.7, 1.0):
        shares = predicted_probabilities(model, source, order=order)["fused"]
        assert (shares.argmax(-1).numpy() == source.label).mean() > 0.9


def test_a_stopped_training_makes_the_same_teachers_again(source, tmp_path):
    whole = made(source, EVERY).model
    state = tmp_path / "training.safetensors"

    def stop_late(step):
        if step.done > 0.85 * step.total:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        made(source, EVERY, resume=state, on_step=stop_late)
    assert state.is_file()
    resumed = made(source, EVERY, resume=state).model
    assert equal_weights(whole, resumed)
    assert not state.exists()


def test_progress_counts_the_steps_of_the_teachers_too(source):
    steps, epochs = [], []
    watch = Watch(on_step=steps.append, on_epoch=lambda record, model: epochs.append(record))
    made(source, EVERY, watch=watch)
    assert [step.done for step in steps] == list(range(1, steps[-1].total + 1))
    # 5 steps × 8 epochs × (two teachers and the head)
    assert {step.total for step in steps} == {120}
    assert len(epochs) == EVERY.epochs


def test_teachers_hold_evenly_spaced_orders_and_only_they_use_lang(source, monkeypatch):
    from omnivat.encoders.lang.bank import load_bank
    from omnivat.training import training

    made_at = []
    once = training.train_once

    def noted(pairs, settings, training, **more):
        made_at.append(
            (settings.order, training.order_draw, more["bank"] is not None, training.lang)
        )
        return once(pairs, settings, training, **more)

    monkeypatch.setattr(training, "train_once", noted)
    settings = replace(EVERY, lang=True, epochs=1, order_teachers=3)
    train(source, head(), settings, bank=load_bank())
    assert made_at == [
        (0.0, "none", True, True),
        (0.5, "none", True, True),
        (1.0, "none", True, True),
        (0.5, "row", False, False),
    ]


def test_teachers_without_drawn_orders_are_refused():
    with pytest.raises(SettingsError, match="order_draw"):
        TrainSettings(order_teachers=1)
