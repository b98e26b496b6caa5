"""Train here: plans, one training at a time, progress, the finished head."""

import base64
import io
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from app.state import ForgottenError
from app.training import REACH, Trainings, coded_map
from app.training_plan import in_words, offers, plan_from
from app.visitor_sets import VisitorSets
from omnivat.head.checkpoint import load_head
from omnivat.kit.errors import DataError

from .conftest import until

SMALL = {"source": "TAG-sim", "width": 16, "epochs": 5, "visitor": "ann"}


@pytest.fixture
def sets(resources):
    found = VisitorSets(resources)
    yield found
    found.shared.close()


def until_ended(trainings, run):
    """Return the last state of a training, with all its epochs."""
    ended = ("done", "failed", "cancelled")
    until(lambda: trainings.state({"run": run})["state"] in ended)
    return trainings.state({"run": run, "since": 0})


def test_a_training_is_watched_to_its_end_and_its_head_is_loaded_and_saved(sets, tmp_path):
    trainings = Trainings(sets)
    started = trainings.start(sets.first, SMALL)
    assert started["total"] == 5
    assert len(started["domain"]) == len(started["label"]) == 80
    state = until_ended(trainings, started["run"])
    assert (state["state"], state["problem"]) == ("done", "")
    assert [one["epoch"] for one in state["epochs"]] == [1, 2, 3, 4, 5]
    later = trainings.state({"run": started["run"], "since": 3})["epochs"]  # only new ones
    assert later == state["epochs"][3:]
    last = state["epochs"][-1]
    assert last["loss"] > 0
    assert 0 <= last["measures"]["accuracy/unseen"] <= 1
    assert len(base64.b64decode(last["map"])) == 2 * 80 * 2 * 2
    loaded = sets.named(state["set"])
    assert loaded.head().settings.width == 16
    assert len(loaded.embeddings()) == 80
    zipfile.ZipFile(io.BytesIO(trainings.saved({"run": started["run"]}))).extractall(tmp_path)
    assert load_head(tmp_path / "trained-head").source == "TAG-sim"


def test_pairs_without_a_class_are_left_out_of_a_training_and_told(
    sets, without_classes, monkeypatch
):
    some = without_classes(sets.first.embeddings(), 2)
    monkeypatch.setattr(sets.first, "embeddings", lambda: some)
    trainings = Trainings(sets)
    # no text is wanted of pairs without a class
    assert offers(sets.first)["first"]["lang"]
    started = trainings.start(sets.first, {**SMALL, "p": None})  # null: as at first
    assert started["left_out"] == 16
    assert "initial p = 0.5, " in started["words"]
    assert until_ended(trainings, started["run"])["state"] == "done"
    zipped = zipfile.ZipFile(io.BytesIO(trainings.saved({"run": started["run"]})))
    assert b"unlabelled" not in zipped.read("trained-head/settings.json")


def test_a_domain_with_one_class_is_refused_before_the_queue(sets, without_classes, monkeypatch):
    some = without_classes(sets.first.embeddings(), 4)
    monkeypatch.setattr(sets.first, "embeddings", lambda: some)
    with pytest.raises(DataError, match="'TAG-sim' has 40 training pairs, of 1 classes; a head"):
        Trainings(sets).start(sets.first, SMALL)


def test_every_step_of_a_training_gives_way_to_requests(sets, monkeypatch):
    ways = []
    monkeypatch.setattr("app.jobs.Job.give_way", lambda job: ways.append(job))
    until_ended(trainings := Trainings(sets), trainings.start(sets.first, SMALL)["run"])
    assert len(ways) >= SMALL["epochs"]


def test_a_training_is_told_in_one_line_of_all_its_settings(resources):
    question = {"source": "TAG-sim", "width": 32, "order": "fixed", "p": 0.3, "lang": False}
    assert in_words(plan_from(question, resources.embeddings()), question) == (
        "TAG-sim, D = 32, keep p fixed, initial p = 0.3, λ = 10, R = 3, E = 4, noise on embeddings"
        " = 4, imitated sensors = 1, epochs = 120, seed = 0, no LANG"
    )


def test_what_is_offered_can_be_trained(resources):
    embeddings = resources.embeddings()
    found = offers(resources)
    plan = plan_from(found["first"], embeddings)
    width, weight = plan.settings.width, plan.training.mma_weight
    assert (plan.source, width, weight) == ("TAG-sim", 64, 10.0)
    assert plan.settings.learn_order
    header = replace(embeddings.header, classes=(*embeddings.header.classes, "fabric"))
    other = replace(embeddings, header=header)
    resources.embeddings._made[:] = [other]
    assert found["first"]["lang"] and not offers(resources)["first"]["lang"]


@pytest.mark.parametrize(
    ("order", "learned", "searched", "drawn"),
    [
        ("gradient", True, False, False),
        ("fixed", False, False, False),
        ("search", True, True, False),
        ("every", False, False, True),
    ],
)
def test_what_p_does_becomes_settings(resources, order, learned, searched, drawn):
    plan = plan_from({**SMALL, "order": order, "p": 0.3}, resources.embeddings())
    assert (plan.settings.learn_order, plan.settings.order) == (learned, 0.3)
    assert (plan.training.order_search, plan.training.order_draw) == (searched, drawn)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"source": "Mars"}, "source is 'Mars'; choose one of TAG-sim, OF Real-sim"),
        ({"source": ["TAG-sim"]}, "source is"),
        ({"width": 4096}, "width is 4096; choose one of 16, 32, 64, 128"),
        ({"width": True}, "width is True"),
        ({"order": "up"}, "order is 'up'"),
        ({"p": 7}, "p is 7; give a number from 0 to 1"),
        ({"p": float("nan")}, "p is nan"),
        ({"epochs": 10**9}, "epochs is 1000000000; give a whole number from 5 to 150"),
        ({"epochs": 7.5}, "epochs is 7.5; give a whole number"),
        ({"levels": "3"}, "levels is '3'"),
    ],
)
def test_settings_that_cannot_be_are_refused_with_what_is_wanted(resources, wrong, sentence):
    with pytest.raises(DataError, match=sentence):
        plan_from({**SMALL, **wrong}, resources.embeddings())


def test_a_training_that_is_not_there_is_told_so(sets):
    trainings = Trainings(sets)
    with pytest.raises(ForgottenError, match="no longer has this training"):
        trainings.state({"run": "nothing"})
    with pytest.raises(DataError, match="visitor has to be a short name"):
        trainings.start(sets.first, {**SMALL, "visitor": None})


def test_a_map_keeps_its_places_within_a_step_of_its_grid():
    flat = np.random.default_rng(0).uniform(-1, 1, (20, 2))
    rows = np.array([0, 4])
    coded = np.frombuffer(base64.b64decode(coded_map(flat, rows)), "<u2").reshape(-1, 2)
    found = coded / 65535 * 2 * REACH - REACH
    np.testing.assert_allclose(found, flat[[0, 4, 10, 14]], atol=2 * REACH / 65535)
