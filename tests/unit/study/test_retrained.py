"""A head at each order: what is trained, what is kept, and frames that agree with those heads."""

import numpy as np
import pytest
import torch

from omnivat.cli import main
from omnivat.data.store import save_embeddings
from omnivat.head.checkpoint import load_head, save_head
from omnivat.head.predict_set import predicted_probabilities
from omnivat.kit.errors import SettingsError
from omnivat.maps.frames import read_frames
from omnivat.maps.sweep import sweep
from omnivat.study import retrained
from omnivat.study.retrained import heads_at_stops, retrained_frames, stop_folder
from omnivat.training import TrainSettings, plan_training, trained_head
from tests.builders import equal_weights

ORDERS = (0.0, 0.5, 1.0)


@pytest.fixture(scope="module")
def plan(make_embeddings):
    return plan_training(
        make_embeddings(), "TAG-sim", head={"width": 16}, training=TrainSettings(epochs=1)
    )


@pytest.fixture(scope="module")
def folder(plan, tmp_path_factory):
    path, done = tmp_path_factory.mktemp("stops"), []
    count = heads_at_stops(
        plan, ORDERS, path, seeds=(0, 1), on_step=lambda step: done.append(step.done)
    )
    assert count == 6 and done == [*range(7)]
    return path


def test_what_processes_are_given_writes_the_same_heads(plan, folder, tmp_path, monkeypatch):
    def here(work, stops, jobs, prepare, *given):
        prepare(*given)
        return map(work, stops)

    monkeypatch.setattr(retrained, "in_processes", here)
    monkeypatch.setattr(retrained, "pin_thread", int)
    assert heads_at_stops(plan, ORDERS[:1], tmp_path, jobs=2) == 1
    one, other = (load_head(stop_folder(f, 0.0, 0)).model for f in (folder, tmp_path))
    assert torch.equal(one.classifier, other.classifier)


@pytest.fixture(scope="module")
def frames(plan, folder):
    return retrained_frames(plan, ORDERS, folder, seeds=(0, 1))


def test_every_head_is_the_one_that_training_at_its_order_gives(plan, folder):
    head = load_head(stop_folder(folder, 0.5, 1))
    alone = trained_head(plan.at(0.5, 1), calibrate=False)
    assert equal_weights(head.model, alone.model)
    assert head.model.order == 0.5


def test_heads_that_are_there_are_not_trained_again(plan, folder):
    assert heads_at_stops(plan, ORDERS, folder, seeds=(0, 1)) == 0
    longer = plan_training(
        plan.embeddings, "TAG-sim", head={"width": 16}, training=TrainSettings(epochs=2)
    )
    assert heads_at_stops(longer, (0.0,), folder, seeds=(7,)) == 1  # other settings, other heads


def test_frames_agree_with_the_library_at_every_stop(plan, folder, frames):
    for index, order in enumerate(ORDERS):
        model = load_head(stop_folder(folder, order, 0)).model
        shares = predicted_probabilities(model, plan.embeddings)["fused"]
        np.testing.assert_array_equal(frames.prediction[index], shares.argmax(1).numpy())
        curves = sweep(model, plan.embeddings, [order]).curves
        for name in ("accuracy/all", "modality_gap/f_hat", "margin/f_hat"):
            assert frames.curves[name][index] == pytest.approx(float(curves[name][0]), abs=1e-6)


def test_curves_over_seeds_hold_mean_and_spread_of_held_out_pairs(folder, frames):
    scores = [
        load_head(stop_folder(folder, 1.0, seed)).metrics["target_accuracy"] for seed in (0, 1)
    ]
    assert frames.curves["seeds:accuracy/unseen/mean"][2] == pytest.approx(np.mean(scores))
    assert frames.curves["seeds:accuracy/unseen/std"][2] == pytest.approx(np.std(scores, ddof=1))
    assert frames.curves["seeds:accuracy/unseen/low"][2] == pytest.approx(min(scores))
    assert {"seeds:modality_gap/f_hat/mean", "seeds:accuracy:vis/unseen/mean"} <= set(frames.curves)


def test_no_order_is_refused(plan, tmp_path):
    with pytest.raises(SettingsError, match="one order, one seed"):
        heads_at_stops(plan, (), tmp_path)


def test_the_command_writes_frames_and_takes_the_heads_own_settings(plan, tmp_path, capsys):
    save_embeddings(tmp_path / "set.safetensors", plan.embeddings)
    save_head(tmp_path / "head", trained_head(plan, calibrate=False))
    files = ["--head", str(tmp_path / "head"), "--embeddings", str(tmp_path / "set.safetensors")]
    command = ["sweep", *files, "--out", str(tmp_path / "retrained.bin")]
    more = ["--retrained", "2", "--seeds", "0", "--jobs", "1", "--set", "epochs=1"]
    assert main([*command, *more, "--keep", str(tmp_path / "heads")]) == 0
    frames = read_frames(tmp_path / "retrained.bin")
    assert frames.orders == (0.0, 1.0) and frames.head["epochs"] == 1
    assert load_head(stop_folder(tmp_path / "heads", 1.0, 0)).settings.width == 16
    assert frames.curves["seeds:accuracy/unseen/std"] == [None, None]
    assert main([*command, *more]) == 0
    assert not (tmp_path / "retrained.bin.heads").exists()
    assert main([*command, "--seeds", "0"]) == 1
    assert "--seeds applies to --retrained N only" in capsys.readouterr().err
