"""Train here: several visitors in one queue."""

from time import sleep
from types import SimpleNamespace

import pytest

from app.shared.messages import BusyError
from app.shared.state import VISITOR, Recent
from app.shared.visitor_sets import VisitorSets
from app.train import runs as training
from app.train.runs import Trainings
from app.train.tab import TrainTab
from omnivat.kit.errors import DataError

from .conftest import until

SMALL = {"source": "TAG-sim", "width": 16, "epochs": 5}


def stay(run, *report):
    """Stay in the first epoch until the training is cancelled."""
    while True:
        run.require_visitor()
        run.job.check()
        sleep(0.01)


@pytest.fixture
def queue(resources, monkeypatch):
    """Return the trainings, and a function that starts one without an end for a visitor."""
    monkeypatch.setattr(training.Run, "take", stay)
    sets = VisitorSets(resources)
    trainings = Trainings(sets)

    def start(name, address=""):
        VISITOR.set(address)
        return trainings.start(sets.first, SMALL, name)

    yield trainings, start
    VISITOR.set("")
    sets.shared.close()


def standing(trainings, runs):
    """Return the state and the place of each training."""
    jobs = [trainings.named(run).job for run in runs]
    return [(job.state, job.place) for job in jobs]


def test_four_visitors_wait_in_order_and_a_cancelled_place_is_free(queue):
    trainings, start = queue
    runs = [start(name) for name in ("ann", "bob", "cy", "dee")]
    until(lambda: standing(trainings, runs)[0] == ("running", 0))
    assert standing(trainings, runs)[1:] == [("waiting", 1), ("waiting", 2), ("waiting", 3)]
    trainings.named(runs[1]).job.cancel()
    left = standing(trainings, runs)
    assert left[1:] == [("cancelled", 0), ("waiting", 1), ("waiting", 2)]
    with pytest.raises(DataError, match="cancel it first"):
        start("dee")
    again = start("bob")  # whose place is free: at the end
    assert standing(trainings, [again]) == [("waiting", 3)]
    trainings.named(runs[0]).job.cancel()
    until(lambda: standing(trainings, runs)[2] == ("running", 0))
    assert standing(trainings, [runs[3], again]) == [("waiting", 1), ("waiting", 2)]


def test_a_full_queue_refuses_in_a_sentence(queue, monkeypatch):
    monkeypatch.setattr(training, "MOST_RUNS", 2)
    trainings, start = queue
    runs = [start(name, name) for name in ("ann", "bob")]
    with pytest.raises(BusyError, match="2 trainings run or wait here already"):
        start("cy")
    trainings.named(runs[1]).job.cancel()
    start("cy")


def test_invented_names_of_one_address_have_half_of_the_queue_and_another_goes_before(
    queue, monkeypatch
):
    monkeypatch.setattr(training, "MOST_RUNS", 6)
    trainings, start = queue
    runs = [start(name, "192.0.2.1") for name in "abc"]
    with pytest.raises(BusyError, match="3 trainings of your address run"):
        start("d", "192.0.2.1")
    other = start("e", "192.0.2.2")
    until(lambda: standing(trainings, runs)[0] == ("running", 0))
    assert standing(trainings, [other, *runs[1:]]) == [("waiting", n) for n in (1, 2, 3)]


def test_the_training_of_a_visitor_who_left_makes_way(queue, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(training, "monotonic", lambda: now[0])
    trainings, start = queue
    left, next_one = start("ann"), start("bob")
    until(lambda: standing(trainings, [left]) == [("running", 0)])
    now[0] = 0.7 * training.ABANDONED_S
    assert standing(trainings, [next_one]) == [("waiting", 1)]
    now[0] = 1.4 * training.ABANDONED_S
    until(lambda: standing(trainings, [next_one]) == [("running", 0)])
    assert standing(trainings, [left]) == [("cancelled", 0)]


def test_a_page_that_has_just_begun_a_training_looks_at_it_though_its_record_is_older(queue):
    trainings, _ = queue
    page = TrainTab.__new__(TrainTab)  # without Gradio: parts are their names
    parts = ("kept", "status", "timer", "go", "stop", "colour", "map", "charts", "earlier")
    vars(page).update({name: name for name in parts}, update=dict, newest=Recent(9))
    page.sets, page.runs, page.settings = trainings.sets, trainings, dict.fromkeys(SMALL)
    asking = SimpleNamespace(session_hash="a page", query_params={})
    record = page.begin(asking, None, 1280, "domain", *SMALL.values())["kept"]
    for known in (None, record):  # None: the page sent its look before it had the reply
        seen = page.look(asking, known, 1280, "domain")
        assert seen["timer"]["active"] and not seen["go"]["interactive"]
    other = SimpleNamespace(session_hash="another page", query_params={})
    assert page.look(other, None, 1280, "domain") == {"timer": {"active": False}}
    page.cancel(asking, record, 1280, "domain")
    until(lambda: not page.look(asking, None, 1280, "domain")["timer"]["active"])
