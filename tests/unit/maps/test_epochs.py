"""What a training shows of its epochs, and that it agrees with the finished head."""

import pytest

from omnivat.maps.epochs import reporter
from omnivat.maps.sweep import sweep
from omnivat.measure.known import scored
from omnivat.training import TrainSettings, Watch, plan_training, trained_head


@pytest.fixture(scope="module")
def parted(make_embeddings):
    return make_embeddings(split=True)


@pytest.fixture(scope="module")
def watched(parted):
    reports, training = [], TrainSettings(epochs=3)
    plan = plan_training(parted, "TAG-sim", head={"width": 16}, training=training)
    shown = reporter(plan, lambda *report: reports.append(report), every=2)
    return scored(trained_head(plan, watch=Watch(on_epoch=shown)), parted), reports


def test_every_epoch_is_shown_and_the_last_one_is_measured(watched):
    _, reports = watched
    assert [record["epoch"] for record, _ in reports] == [1, 2, 3]
    assert ["accuracy/unseen" in record for record, _ in reports] == [False, True, True]
    assert [points is not None for _, points in reports] == [False, True, True]
    assert all({"loss", "mma", "nod", "cross_entropy"} <= set(record) for record, _ in reports)


def test_the_last_report_agrees_with_the_finished_head(watched, parted):
    head, reports = watched
    measures, points = reports[-1]
    assert measures["accuracy/unseen"] == pytest.approx(head.metrics["target_accuracy"])
    home = head.metrics["domains"][0]["scores"]
    assert measures["accuracy/source_test"] == pytest.approx(home["fused"]["accuracy"])
    assert measures["accuracy:tac/source_test"] == pytest.approx(home["tac"]["accuracy"])
    curves = sweep(head.model, parted, [head.model.order]).curves
    for name in ("modality_gap/f_hat", "domain_gap/f_hat", "margin/f_hat"):
        assert measures[name] == pytest.approx(float(curves[name][0]), abs=1e-5)
    assert points.shape == (2 * len(parted), 2)
    assert measures["order"] == head.model.order
