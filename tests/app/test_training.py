"""Train here: plans, one training at a time, progress, the finished head."""

import io
import zipfile
from dataclasses import replace

import pytest

from app.serving.routes import head_file
from app.shared.state import ForgottenError
from app.shared.visitor_sets import VisitorSets
from app.train.plan import NUMBERS, offered, plan_from
from app.train.runs import Trainings
from omnivat.head.checkpoint import load_head
from omnivat.kit.errors import DataError

from .conftest import until

SMALL = {"source": "TAG-sim", "width": 16, "epochs": 5}


@pytest.fixture
def sets(resources):
    found = VisitorSets(resources)
    yield found
    found.shared.close()


def ended(trainings, key):
    """Return a run after its end."""
    until(lambda: not trainings.named(key).active)
    return trainings.named(key)


def test_a_training_is_watched_to_its_end_and_its_head_is_loaded_and_saved(sets, tmp_path):
    trainings = Trainings(sets)
    key = trainings.start(sets.first, SMALL, "ann")
    run = ended(trainings, key)
    assert (run.job.state, run.job.problem, run.plan.training.epochs) == ("done", "", 5)
    assert [one["epoch"] for one in run.epochs] == [1, 2, 3, 4, 5]
    last = run.epochs[-1]
    assert last["loss"] > 0
    assert 0 <= last["accuracy/unseen"] <= 1
    places, domain, label = run.map()
    assert places.shape == (160, 2) and len(domain) == len(label) == 80
    loaded = sets.named(run.loaded)
    assert loaded.head().settings.width == 16
    assert loaded.embeddings() is sets.first.embeddings()  # in memory once
    assert trainings.finished([key, "another"]) == [run]
    zipfile.ZipFile(io.BytesIO(head_file(loaded))).extractall(tmp_path)
    assert load_head(tmp_path / "trained-head").source == "TAG-sim"


def test_pairs_without_a_class_are_left_out_of_a_training_and_counted(
    sets, without_classes, monkeypatch
):
    some = without_classes(sets.first.embeddings(), 2)
    monkeypatch.setattr(sets.first, "embeddings", lambda: some)
    trainings = Trainings(sets)
    assert offered(sets.first)[2]  # no text is wanted of pairs without a class
    # an empty field: the first value
    run = ended(trainings, trainings.start(sets.first, {**SMALL, "p": None}, "ann"))
    assert run.plan.left_out == 16
    assert "initial p = 0.5, " in run.words
    assert run.job.state == "done"
    assert "unlabelled" not in sets.named(run.loaded).head().settings.classes


def test_a_domain_with_one_class_is_refused_before_the_queue(sets, without_classes, monkeypatch):
    some = without_classes(sets.first.embeddings(), 4)
    monkeypatch.setattr(sets.first, "embeddings", lambda: some)
    with pytest.raises(DataError, match="'TAG-sim' has 40 training pairs, of 1 classes; a head"):
        Trainings(sets).start(sets.first, SMALL, "ann")


def test_every_step_of_a_training_gives_way_to_requests(sets, monkeypatch):
    ways = []
    monkeypatch.setattr("app.shared.jobs.Job.give_way", lambda job: ways.append(job))
    ended(trainings := Trainings(sets), trainings.start(sets.first, SMALL, "ann"))
    assert len(ways) >= SMALL["epochs"]


def test_what_is_offered_can_be_trained(resources):
    embeddings = resources.embeddings()
    domains, first, lang = offered(resources)
    assert lang and first == "TAG-sim" and first in domains
    numbers = {name: row[-1] for name, row in NUMBERS.items()}
    plan = plan_from({"source": first, "lang": lang, **numbers}, embeddings)
    assert (plan.source, plan.settings.width) == ("TAG-sim", 64)
    header = replace(embeddings.header, classes=(*embeddings.header.classes, "fabric"))
    other = replace(embeddings, header=header)
    resources.embeddings._made[:] = [other]
    assert not offered(resources)[2]


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
        ({"width": 4096}, "width is 4096; choose one of 16, 32, 64, 128"),
        ({"width": True}, "width is True"),
        ({"p": 7}, "p is 7; give a number from 0 to 1"),
        ({"p": float("nan")}, "p is nan"),
        ({"epochs": 10**9}, "epochs is 1000000000; give a whole number from 5 to 150"),
        ({"levels": "3"}, "levels is '3'"),
    ],
)
def test_settings_that_cannot_be_are_refused_with_what_is_wanted(resources, wrong, sentence):
    with pytest.raises(DataError, match=sentence):
        plan_from({**SMALL, **wrong}, resources.embeddings())


def test_a_training_that_is_not_there_is_refused(sets):
    trainings = Trainings(sets)
    with pytest.raises(ForgottenError, match="no longer has this training"):
        trainings.named("nothing")
    with pytest.raises(DataError, match="visitor has to be a short name"):
        trainings.start(sets.first, SMALL, "x" * 41)
