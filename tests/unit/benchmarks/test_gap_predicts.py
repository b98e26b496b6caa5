"""Correlations of gaps with accuracy: the arithmetic, and the shipped record."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import rankdata, spearmanr

from benchmarks import gap_predicts
from omnivat.maps.frames.file import frames_header


def test_the_correlation_of_ranks_is_spearmans_and_constants_give_zero():
    x, y = np.random.default_rng(0).integers(0, 9, size=(2, 40))
    found = gap_predicts.agreement(rankdata(x), rankdata(y))
    assert found == pytest.approx(spearmanr(x, y).statistic)
    assert gap_predicts.agreement(np.ones(5), np.arange(5.0)) == 0


def test_an_interval_narrows_with_more_units():
    random = np.random.default_rng(1)
    widths = []
    for count in (20, 500):
        x = random.normal(size=count)
        y = x + random.normal(size=count)
        mean, low, high = gap_predicts.interval(count, lambda rows, x=x, y=y: gap_predicts.agreement(x[rows], y[rows]))
        assert low < mean < high
        widths.append(high - low)
    assert widths[1] < widths[0] / 2


def test_the_shipped_correlations_with_retrieval_are_those_of_the_ladders_records():
    record = json.loads((Path("docs/benchmarks") / "gap_predicts.json").read_text())
    again = json.loads(json.dumps(gap_predicts.retrieval()))
    assert again == record["retrieval"]


def test_the_shipped_record_is_that_of_the_shipped_sweeps():
    record = json.loads((Path("docs/benchmarks") / "gap_predicts.json").read_text())
    for name, folder in gap_predicts.SETS.items():
        curves = frames_header(folder / "trained.bin")["curves"]
        own = record["stops"][name][gap_predicts.FILES["trained.bin"]]["f_hat"]
        for measure in gap_predicts.MEASURES:
            wanted = spearmanr(curves[f"{measure}/f_hat"], curves["accuracy/unseen"]).statistic
            assert own[measure][0] == pytest.approx(wanted)
