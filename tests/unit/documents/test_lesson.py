"""The key of the lesson's worksheet, computed again from the shipped files."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from omnivat.head.heads import EXAMPLES, default_embeddings, default_head
from omnivat.kit.stages import STAGES
from omnivat.maps.frames.file import frames_header

ROOT = Path(__file__).resolve().parents[3]
LESSON = ROOT / "docs" / "lesson.md"


def key(number):
    """Return one entry of the key."""
    text = LESSON.read_text(encoding="utf-8").partition("## Key")[2].partition("## Quiz")[0]
    entries = re.split(r"^(\d+)\. ", text, flags=re.MULTILINE)
    return dict(zip(map(int, entries[1::2]), entries[2::2], strict=True))[number]


def percents(*shares):
    return [f"{100 * share:.0f}" for share in shares]


def said(number):
    """Return every number in an entry."""
    return re.findall(r"\d+(?:\.\d+)?", key(number))


def trained(folder):
    header = frames_header(folder / "retrained.bin")
    return np.array(header["orders"]), np.array(header["curves"]["seeds:accuracy/unseen/mean"])


@pytest.fixture(scope="module")
def twins():
    return json.loads((EXAMPLES / "twins.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def unseen():
    from omnivat.data.store import load_embeddings
    from omnivat.head.checkpoint import load_head
    from omnivat.measure.unseen import unseen_summary

    return unseen_summary(load_head(default_head()), load_embeddings(default_embeddings()))


def test_the_sensor_alone_costs_more_than_half_and_filled_dots_bring_back_most_of_it(twins):
    printed, filled, relief = twins["away"]["touch"][0]
    home = twins["accuracy"]["touch"][0][0][0][0][0]
    assert said(1) == [*percents(home, printed[0][0]), "20"]
    assert said(2) == percents(filled[0][0])
    assert said(3) == percents(printed[-1][0], filled[-1][0])
    assert printed[0][0] < 0.5 * home
    assert filled[0][0] - printed[0][0] > 0.5 * (home - printed[0][0])
    assert said(4)[:3] == [*percents(relief[0][0], relief[2][0]), "20"]
    assert relief[0][0] > filled[0][0]


def test_at_every_p_the_steps_close_both_gaps_and_p_moves_them_little():
    curves = frames_header(EXAMPLES / "frames.bin")["curves"]
    gaps = [curves[f"{name}/f_hat"] for name in ("modality_gap", "domain_gap")]
    raw = [curves[f"{name}/raw"][0] for name in ("modality_gap", "domain_gap")]
    ends = [end for gap in gaps for end in (min(gap), max(gap))]
    assert said(5)[:6] == [f"{value:.2f}" for value in (*ends, *raw)]
    assert all(
        max(gap) - min(gap) < before - max(gap) for gap, before in zip(gaps, raw, strict=True)
    )


def test_the_mean_alone_mends_little_and_mean_and_spread_more():
    places = json.loads((EXAMPLES / "twins.map.json").read_text(encoding="utf-8"))["accuracy"]
    assert said(6)[:3] == percents(*places)
    assert places[1] - places[0] < 0.5 * (places[2] - places[0])


def test_chirps_have_the_order_and_the_figures_of_the_key():
    orders, right = trained(EXAMPLES / "chirps")
    assert said(7) == [
        f"{orders[right.argmax()]:g}",
        *percents(right.max(), right[orders == 1][0]),
        "1",
    ]
    assert right.argmin() == len(right) - 1  # p = 1 is the worst


@pytest.mark.slow
def test_the_touch_is_right_where_the_photo_deceives(unseen):
    alike = unseen["look_alikes"]
    photo, touch = alike["answers/vis"], alike["answers/tac"]
    assert said(8) == percents(touch["share"], photo["share"])
    assert said(9) == percents(touch["low"], touch["high"], photo["low"], photo["high"])
    assert touch["low"] > photo["high"] and photo["share"] < unseen["chance"]


def test_the_step_after_the_relu_is_the_first_that_moves_with_p():
    curves = frames_header(EXAMPLES / "frames.bin")["curves"]
    moves = [np.ptp(np.array(curves[f"domain_gap/{stage}"], float)) > 1e-6 for stage in STAGES]
    assert moves == [False, False, True, True, True]
    assert "after the ReLU" in key(10)
