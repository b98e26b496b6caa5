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
LESSON, WEB = ROOT / "docs" / "lesson.md", ROOT / "app" / "web" / "explore"


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
    header = frames_header(folder / "trained.bin")
    return np.array(header["orders"]), np.array(header["curves"]["accuracy/unseen"])


@pytest.fixture(scope="module")
def found():
    from omnivat.data.store import load_embeddings
    from omnivat.head.checkpoint import load_head
    from omnivat.measure.ladder import rungs
    from omnivat.measure.unseen import unseen_summary

    head, data = load_head(default_head()), load_embeddings(default_embeddings())
    return unseen_summary(head, data), {one["rung"]: one for one in rungs(head, data, source="")}


def test_chirps_have_the_order_and_the_figures_of_the_key():
    orders, right = trained(EXAMPLES / "chirps")
    assert said(1) == [f"{orders[right.argmax()]:g}"]
    ends = percents(right.max(), right[orders == 1][0], right[orders == 0][0])
    assert [name for name in said(2) if len(name) == 2] == ends
    assert right.argmin() == len(right) - 1  # p = 1 is the worst


def test_the_order_hardly_matters_on_the_sensors():
    _, right = trained(EXAMPLES)
    assert said(3) == percents(right.min(), right.max())


def test_domains_are_shifted_together():
    kept = json.loads(default_embeddings().with_suffix(".centred.json").read_text())
    apart, centred = kept["pca"]["curves"]["domain_gap/raw"]
    assert said(5) == [f"{apart:.2f}", f"{centred:.2f}"]


@pytest.mark.slow
def test_home_and_away_are_those_of_the_head(found):
    summary, rungs = found
    home = next(one for one in summary["domains"] if one["is_source"])["answers/fused"]
    away = summary["unseen"]["answers/fused"]
    wanted = percents(home["share"], away["share"], away["low"], away["high"], summary["chance"])
    assert said(4) == wanted
    assert rungs["home"]["accuracy"] == home["share"]


@pytest.mark.slow
def test_labels_mend_most_and_pictures_without_labels_hardly(found):
    script = (WEB / "waterfall.js").read_text(encoding="utf-8")
    shown = re.findall(r'"(\w+)"', re.search(r"SHOWN = \[(.*?)\]", script)[1])
    rungs = {name: one for name, one in found[1].items() if name in shown and name != "home"}
    right = {name: one["accuracy"] for name, one in rungs.items()}
    assert max(right, key=right.get) == "k3"
    bare = max(right[name] for name in ("n5", "n20", "all"))
    labels = percents(right["k3"], rungs["k3"]["low"], rungs["k3"]["high"])
    assert said(6) == [*labels, *percents(right["m2"], bare, right["none"])]
    assert rungs["n5"]["low"] < rungs["none"]["high"]
    assert rungs["m2"]["from"] == "records" and "not compared" in " ".join(key(6).split())


@pytest.mark.slow
def test_the_touch_is_right_where_the_photo_deceives(found):
    alike = found[0]["look_alikes"]
    photo, touch = alike["answers/vis"], alike["answers/tac"]
    assert said(7) == percents(touch["share"], photo["share"])
    assert said(8) == percents(touch["low"], touch["high"], photo["low"], photo["high"])
    assert touch["low"] > photo["high"] and photo["share"] < found[0]["chance"]


def test_the_step_after_the_relu_is_the_first_that_moves_with_p():
    curves = frames_header(EXAMPLES / "frames.bin")["curves"]
    moves = [np.ptp(np.array(curves[f"domain_gap/{stage}"], float)) > 1e-6 for stage in STAGES]
    assert moves == [False, False, True, True, True]
    assert "after the ReLU" in key(9)
