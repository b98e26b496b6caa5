"""Spreads, intervals, texts and plots, against figures worked out by hand."""

import math

import numpy as np
import pytest

from omnivat.study.reports.intervals import Interval, Spread, spread, spread_lines, t_interval
from omnivat.study.reports.markdown import interval_text, markdown, percent, spread_text


def test_a_spread_has_n_minus_one_in_its_deviation():
    found = spread([1.0, 2.0, 4.0])
    assert found.mean == pytest.approx(7 / 3)
    assert found.std == pytest.approx(np.std([1, 2, 4], ddof=1))
    assert math.isnan(spread([1.0]).std)
    assert spread([]).n == 0


def test_the_t_interval_is_students_for_ten_known_values():
    """Sleep data of Student (1908): mean 1.58, 95 % interval 0.70 to 2.46."""
    sleep = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4]
    found = t_interval(sleep)
    assert (round(found.mean, 2), round(found.low, 2), round(found.high, 2)) == (1.58, 0.7, 2.46)
    wide = t_interval([-1.0, 1.0, 0.5])
    assert wide.low < 0 < wide.high


def test_figures_are_written_with_one_digit_and_bars_escaped():
    assert percent(0.5) == "50.0"
    assert percent(math.nan) == "–"
    assert spread_text(Spread(mean=0.5, std=0.012, n=3)) == "50.0 ± 1.2"
    assert interval_text(Interval(mean=0.021, low=-0.004, high=0.046, n=6)) == "+2.1 [-0.4, 4.6]"
    assert markdown(["a"], [["x|y"]]).endswith("| x\\|y |")


def test_spreads_become_places_means_and_deviations_of_a_line():
    assert spread_lines([spread([1.0, 3.0])]) == ([0.0], [2.0], [pytest.approx(2**0.5)])
