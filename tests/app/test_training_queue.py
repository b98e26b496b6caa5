"""Train here: several visitors in one queue."""

import time

import pytest

from app import training
from app.messages import BusyError
from app.state import VISITOR
from app.training import Trainings
from app.visitor_sets import VisitorSets
from omnivat.kit.errors import DataError

LONG = {"source": "TAG-sim", "width": 16, "epochs": 100}


@pytest.fixture
def queue(resources):
    """Return the trainings, and a function that starts a long one for a visitor."""
    sets = VisitorSets(resources)
    trainings = Trainings(sets)

    def start(name, address=""):
        VISITOR.set(address)
        return trainings.start(sets.first, {**LONG, "visitor": name})["run"]

    yield trainings, start
    VISITOR.set("")
    sets.shared.close()


def standing(trainings, runs):
    """Return the state and the place of each training."""
    found = [trainings.state({"run": run}) for run in runs]
    return [(one["state"], one["place"]) for one in found]


def until(condition, seconds=30):
    """Wait for a condition."""
    for _ in range(int(seconds / 0.02)):
        if condition():
            return
        time.sleep(0.02)
    raise AssertionError("it did not happen")


def test_four_visitors_wait_in_order_and_a_cancelled_place_is_free(queue):
    trainings, start = queue
    runs = [start(name) for name in ("ann", "bob", "cy", "dee")]
    until(lambda: standing(trainings, runs)[0] == ("running", 0))
    assert standing(trainings, runs)[1:] == [("waiting", 1), ("waiting", 2), ("waiting", 3)]
    trainings.cancel({"run": runs[1]})
    left = standing(trainings, runs)
    assert left[1:] == [("cancelled", 0), ("waiting", 1), ("waiting", 2)]
    with pytest.raises(DataError, match="cancel it first"):
        start("dee")
    again = start("bob")  # whose place is free: at the end
    assert standing(trainings, [again]) == [("waiting", 3)]
    trainings.cancel({"run": runs[0]})
    until(lambda: standing(trainings, runs)[2] == ("running", 0))
    assert standing(trainings, [runs[3], again]) == [("waiting", 1), ("waiting", 2)]


def test_a_full_queue_refuses_in_a_sentence(queue, monkeypatch):
    monkeypatch.setattr(training, "MOST_RUNS", 2)
    trainings, start = queue
    runs = [start(name) for name in ("ann", "bob")]
    with pytest.raises(BusyError, match="2 trainings run or wait here already"):
        start("cy")
    trainings.cancel({"run": runs[1]})
    start("cy")


def test_the_training_of_a_visitor_who_left_makes_way(queue, monkeypatch):
    trainings, start = queue
    left, next_one = start("ann"), start("bob")
    until(lambda: standing(trainings, [left]) == [("running", 0)])
    monkeypatch.setattr(training, "ABANDONED_S", 0.5)
    until(lambda: standing(trainings, [next_one])[0][0] == "running")
    assert standing(trainings, [left]) == [("cancelled", 0)]
