"""The time that work takes, as text."""

import pytest

from omnivat.kit.progress import time_text


@pytest.mark.parametrize(
    ("seconds", "text"), [(5, "5 s"), (200, "3 min 20 s"), (7300, "2 h 1 min")]
)
def test_a_duration_has_at_most_two_units(seconds, text):
    assert time_text(seconds) == text
