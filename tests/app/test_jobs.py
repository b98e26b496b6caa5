"""Jobs: priority, cancellation, and a final state and sentence for every job."""

from threading import Barrier, Event
from threading import enumerate as enumerate_threads
from weakref import ref

import pytest

from app.shared.jobs import Jobs
from app.shared.messages import UNEXPECTED, BusyError, CancelledError, UnexpectedError
from omnivat.kit.errors import DataError

from .conftest import until


@pytest.fixture
def jobs():
    jobs = Jobs()
    yield jobs
    jobs.close()


def held(jobs, **more):
    """Start a job that runs until an event; return the job and the event."""
    go, there = Event(), Event()

    def work(job):
        job.check()
        there.set()
        while not go.wait(0.005):
            job.check()
        return "held"

    job = jobs.start(work, lane="long", **more)
    return job, go, there


def test_waiting_jobs_have_places_and_the_better_priority_goes_first(jobs):
    first, go, there = held(jobs)
    there.wait(60)
    order = []
    late = jobs.start(lambda job: order.append("late"), lane="long", priority=2)
    soon = jobs.start(lambda job: order.append("soon"), lane="long", priority=1)
    assert (first.place, soon.place, late.place) == (0, 1, 2)
    assert late.state == "waiting"
    go.set()
    late.future.result(60)
    assert order == ["soon", "late"]


def test_a_visitor_with_one_job_does_not_wait_for_all_of_another(jobs, monkeypatch):
    monkeypatch.setattr("app.shared.jobs.WAITING_JOBS", 8)
    first, go, there = held(jobs, visitor="many")
    there.wait(60)
    many = [jobs.start(lambda _: None, lane="long", visitor="many") for _ in range(4)]
    with pytest.raises(BusyError):
        jobs.start(lambda _: None, lane="long", visitor="many")
    few = [jobs.start(lambda _: None, lane="long", visitor="few") for _ in range(2)]
    assert [job.place for job in few] == [1, 3] and [job.place for job in many] == [2, 4, 5, 6]
    go.set()
    first.future.result(60)


def test_a_running_job_gives_way_to_a_better_one_and_goes_on_after_it(jobs):
    slow, go, there = held(jobs, priority=5)
    there.wait(60)
    assert (
        jobs.start(lambda job: "first look", lane="long", priority=0).future.result(60)
        == "first look"
    )
    assert slow.state == "running"
    go.set()
    assert slow.future.result(60) == "held"


def test_the_work_of_an_owner_who_is_gone_is_stopped_running_or_waiting(jobs):
    running, _, there = held(jobs, owner="gone")
    there.wait(60)
    waiting, _, _ = held(jobs, owner="gone")
    other, go, _ = held(jobs, owner="here")
    go.set()
    jobs.cancel_owner("gone")
    assert other.future.result(60) == "held"
    for job in (running, waiting):
        with pytest.raises(CancelledError, match="was cancelled"):
            job.future.result(60)
        assert job.state == "cancelled"


def test_a_paused_job_can_be_cancelled(jobs):
    slow, _, there = held(jobs, priority=5)
    there.wait(60)
    better, go, up = held(jobs, priority=0)
    up.wait(60)
    slow.cancel()
    with pytest.raises(CancelledError):
        slow.future.result(60)
    go.set()
    assert better.future.result(60) == "held"


EMPTY = DataError("The set is empty; choose another.")


@pytest.mark.parametrize(
    "error",
    [
        ZeroDivisionError(),
        SystemExit(3),
        EMPTY,
    ],
    ids=lambda error: type(error).__name__,
)  # fmt: skip
def test_whatever_is_raised_ends_in_a_sentence_and_the_lane_goes_on(jobs, error):
    def work(job):
        raise error

    job = jobs.start(work, lane="long")
    with pytest.raises(DataError if error is EMPTY else UnexpectedError):
        job.future.result(60)
    assert job.problem == (str(EMPTY) if error is EMPTY else UNEXPECTED)
    assert job.state == "failed"
    assert jobs.start(lambda job: 1, lane="long").future.result(60) == 1


def test_a_job_past_its_time_is_stopped_in_a_sentence_and_waiting_does_not_count(jobs, monkeypatch):
    now = [0.0]
    monkeypatch.setattr("app.shared.jobs.monotonic", lambda: now[0])
    slow, go, there = held(jobs)
    there.wait(60)
    late, _, begun = held(jobs, deadline_s=10)
    now[0] = 20
    assert late.state == "waiting"
    go.set()
    assert begun.wait(60)
    now[0] = 31
    with pytest.raises(BusyError, match="longer than allowed"):
        late.future.result(60)
    assert slow.future.result(60) == "held"


def test_a_full_queue_refuses_in_a_sentence(jobs, monkeypatch):
    monkeypatch.setattr("app.shared.jobs.WAITING_JOBS", 2)
    _, _, there = held(jobs)
    there.wait(60)
    held(jobs)
    held(jobs)
    with pytest.raises(BusyError, match="Too much is waiting"):
        held(jobs)


def test_work_in_small_steps_gives_way_to_requests_but_never_stops(jobs, monkeypatch):
    monkeypatch.setattr("app.shared.jobs.GIVE_WAY_S", 60.0)
    go, there, order = Event(), Event(), []

    def training(job):
        there.wait(60)
        job.give_way()
        order.append("step")

    def request(job):
        there.set()
        go.wait(60)
        order.append("request")

    asked = jobs.start(request, lane="quick")
    trained = jobs.start(training, lane="long")
    there.wait(60)
    go.set()
    trained.future.result(60)
    assert order == ["request", "step"]
    assert asked.state == "done"
    go.clear()
    there.clear()
    monkeypatch.setattr("app.shared.jobs.GIVE_WAY_S", 0.01)
    busy = jobs.start(request, lane="quick")
    jobs.start(training, lane="long").future.result(60)
    assert order == ["request", "step", "step"]  # though the request still runs
    go.set()
    busy.future.result(60)


def test_uploads_take_every_slot_and_a_drag_takes_one_more(jobs):
    go = Event()
    uploads = [jobs.start(lambda _: go.wait(60), lane="quick", priority=1) for _ in range(3)]
    drag = jobs.start(lambda _: go.wait(60), lane="quick")
    second = jobs.start(lambda _: "drag", lane="quick")
    until(lambda: [one.state for one in (*uploads[:2], drag)] == ["running"] * 3)
    assert (uploads[2].state, second.state, second.place) == ("waiting", "waiting", 1)
    go.set()
    assert second.future.result(60) == "drag"


@pytest.mark.parametrize("priority", [0, 1])
def test_frames_of_one_visitor_in_every_slot_do_not_hold_up_another(jobs, priority):
    go, here = Event(), Barrier(3)

    def frame(job):
        here.wait(60)
        go.wait(60)

    frames = [jobs.start(frame, lane="quick", visitor="many") for _ in range(3)]
    here.wait(60)
    own = jobs.start(lambda job: "own", lane="quick", visitor="few", priority=priority)
    assert own.future.result(60) == "own"
    assert [one.state for one in frames] == ["running", "running", "waiting"]
    here.abort()
    go.set()


@pytest.mark.parametrize(("longest", "place"), [(60.0, 2), (0.0, 1)])
def test_an_upload_that_has_waited_long_comes_before_newer_drags(jobs, monkeypatch, longest, place):
    monkeypatch.setattr("app.shared.jobs.LONGEST_WAIT_S", longest)
    go = Event()
    for _ in range(2):
        jobs.start(lambda job: go.wait(60), lane="quick")
    upload = jobs.start(lambda job: None, lane="quick", priority=1)
    jobs.start(lambda job: None, lane="quick")
    assert upload.place == place
    go.set()
    upload.future.result(60)


def test_a_closed_runner_leaves_no_thread(jobs):
    before = set(enumerate_threads())
    job, _, there = held(jobs)
    there.wait(60)
    jobs.close(60)
    assert job.state == "cancelled"
    until(lambda: not set(enumerate_threads()) - before)


def test_a_failed_job_keeps_nothing_that_its_work_held(jobs):
    class Large:
        pass

    held = []

    def work(job):
        large = Large()
        held.append(ref(large))
        raise DataError("This set cannot be shown.")

    job = jobs.start(work, lane="quick")
    with pytest.raises(DataError, match="cannot be shown"):
        job.future.result(60)
    del work
    jobs.close(60)  # waits for the thread
    assert held[0]() is None
