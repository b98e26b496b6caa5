"""Spreads, intervals, texts and plots, against figures worked out by hand."""

import math

import numpy as np
import pytest

from omnivat.study.reports.intervals import Interval, Spread, spread
from omnivat.study.reports.markdown import interval_text, markdown, percent, spread_text


def test_a_spread_has_n_minus_one_in_its_deviation():
    found = spread([1.0, 2.0, 4.0])
    assert found.mean == pytest.approx(7 / 3)
    assert found.std == pytest.approx(np.std([1, 2, 4], ddof=1))
    assert math.isnan(spread([1.0]).std)
    assert math.isnan(spread([]).mean)


def test_figures_are_written_with_one_digit_and_bars_escaped():
    assert percent(0.5) == "50.0"
    assert percent(math.nan) == "–"
    assert spread_text(Spread(mean=0.5, std=0.012)) == "50.0 ± 1.2"
    assert interval_text(Interval(0.021, -0.004, 0.046)) == "+2.1 [-0.4, 4.6]"
    assert markdown(["a"], [["x|y"]]).endswith("| x\\|y |")
