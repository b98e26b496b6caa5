"""The time that work takes, as text, and how much of it is left."""

import pytest

from omnivat.kit import progress
from omnivat.kit.progress import Pace, Step, time_text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (59, "59 s"),
        (60, "1 min 0 s"),
        (200, "3 min 20 s"),
        (3600, "1 h 0 min"),
        (7300, "2 h 1 min"),
    ],
)
def test_a_duration_has_at_most_two_units(seconds, text):
    assert time_text(seconds) == text


def test_the_rest_takes_as_long_a_step_as_those_of_this_stage_took(monkeypatch):
    clock = iter([100, 107, 110, 130, 150, 170])
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock))
    pace = Pace()
    steps = [(5, 10), (5, 10), (7, 10), (0, 3), (1, 3), (2, 0)]  # an earlier run did five
    assert [pace.left(Step(done=done, total=total)) for done, total in steps] == [
        "", "", "15 s left", "", "40 s left", "",
    ]  # fmt: skip
