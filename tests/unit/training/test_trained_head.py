"""From a plan to a head in memory: what it holds, that it stops, that the command agrees."""

from contextvars import copy_context

import numpy as np
import pytest

from omnivat.cli import main
from omnivat.data.store import save_embeddings
from omnivat.head.checkpoint import load_head
from omnivat.kit.errors import DataError
from omnivat.kit.progress import CHECK
from omnivat.measure.known import scored
from omnivat.training import TrainSettings, Watch, plan_like, plan_training, trained_head
from tests.builders import equal_weights

SHORT = TrainSettings(epochs=3)
SMALL = {"width": 16}


def planned(pairs):
    return plan_training(pairs, "TAG-sim", head=SMALL, training=SHORT)


@pytest.fixture(scope="module")
def pairs(make_embeddings):
    return make_embeddings()


@pytest.fixture(scope="module")
def parted(make_embeddings):
    return make_embeddings(split=True)


@pytest.fixture(scope="module")
def head(parted):
    return trained_head(planned(parted))


def test_the_command_writes_the_head_that_the_function_returns(head, parted, tmp_path):
    save_embeddings(tmp_path / "set.safetensors", parted)
    command = ["train", "--embeddings", str(tmp_path / "set.safetensors"), "--source", "TAG-sim"]
    assert (
        main(
            [*command, "--out", str(tmp_path / "head"), *["--set", "width=16", "--set", "epochs=3"]]
        )
        == 0
    )
    written = load_head(tmp_path / "head")
    assert equal_weights(head.model, written.model)
    assert written.metrics == scored(head, parted).metrics
    assert written.model.temperatures == head.model.temperatures


def test_pairs_without_a_class_are_left_out_of_training_and_counted(pairs, without_classes):
    some = without_classes(pairs, 2)
    plan = plan_training(some, "TAG-sim", head=SMALL, training=SHORT)
    assert plan.settings.classes == pairs.header.classes[:3]
    assert (len(plan.rows), plan.left_out) == (24, 16)
    assert plan.bank is not None  # texts are wanted of classes alone
    head = scored(trained_head(plan, calibrate=False), some)
    assert head.settings.classes == pairs.header.classes[:3]
    assert (head.provenance["pairs"], head.provenance["left_out"]) == (24, 16)
    assert [one["left_out"] for one in head.metrics["domains"]] == [16, 16]


@pytest.mark.parametrize(("unnamed", "classes"), [(5, 0), (4, 1)])
def test_a_domain_whose_pairs_have_no_class_or_one_beside_none_is_refused(
    pairs, without_classes, unnamed, classes
):
    some = without_classes(pairs, unnamed)
    assert some.learnable == ()
    sentence = f"'TAG-sim' has 40 training pairs, of {classes} classes; a head needs two"
    with pytest.raises(DataError, match=sentence):
        plan_training(some, "TAG-sim", head=SMALL, training=SHORT)


def test_a_training_can_be_stopped_while_its_calibration_is_fitted(pairs):
    steps, looked = [], []

    def check():
        looked.append(len(steps))
        if looked.count(len(steps)) > 2:  # the head's own steps are over
            raise KeyboardInterrupt

    def stopped():
        CHECK.set(check)
        trained_head(planned(pairs), watch=Watch(on_step=steps.append))

    with pytest.raises(KeyboardInterrupt):
        copy_context().run(stopped)
    assert steps[-1].done == steps[-1].total


def test_a_domain_without_pairs_of_a_part_is_refused(pairs):
    with pytest.raises(DataError, match="No domain is called 'Mars'"):
        plan_training(pairs, "Mars")
    empty = pairs.select(np.flatnonzero(pairs.domain == 1))
    with pytest.raises(DataError, match="'TAG-sim' has 0 training pairs"):
        plan_training(empty, "TAG-sim")


def test_a_plan_like_a_head_has_its_settings_and_source(head, parted):
    plan = plan_like(head, parted)
    assert plan.settings == head.settings and plan.training == SHORT
    assert (plan.source, plan.seed) == ("TAG-sim", 0)
    held = plan.at(0.3, 5)
    assert held.settings.order == 0.3 and not held.settings.learn_order and held.seed == 5
