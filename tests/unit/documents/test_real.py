"""docs/real.md states what its record holds."""

import json
from pathlib import Path
from statistics import median

import pytest

ROOT = Path(__file__).resolve().parents[3]
RECORDS = json.loads((ROOT / "docs/benchmarks/real.json").read_text(encoding="utf-8"))["records"]
PAGE = (ROOT / "docs/real.md").read_text(encoding="utf-8").replace("**", "").replace("−", "-")
SHARES = {(one["part"], one["what"]): one for one in RECORDS if one["part"] != "distance"}
GAPS = {
    (one["modality"], one["from"], one["to"]): one["centroid"]
    for one in RECORDS
    if one["part"] == "distance"
}


def text(record, digits=1, sign=""):
    value, low, high = (100 * record[name] for name in ("value", "low", "high"))
    return f"{value:{sign}.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"


@pytest.mark.parametrize(
    ("what", "sign"),
    [
        ("linear maps", ""),
        ("ERM-MLP", ""),
        ("OmniVaT", ""),
        ("OmniVaT without training noise", ""),
        ("OmniVaT without training noise, p = 0", ""),
        ("OmniVaT without training noise less linear maps", "+"),
        ("OmniVaT without training noise less ERM-MLP", "+"),
        ("learned p less p = 0", "+"),
        ("profile of 20 pictures less none, linear maps", "+"),
    ],
)
def test_figures_at_home_are_those_of_the_record(what, sign):
    assert text(SHARES["vt60", what], sign=sign) in PAGE


def test_the_gain_of_two_images_is_that_of_the_record():
    gain = SHARES["vt60", "two images less the photo, linear maps"]
    assert text(gain, sign="+").replace(" [", " points [") in PAGE


def test_figures_of_a_new_sensor_are_those_of_the_record():
    for what in ("linear maps of OF Real-sim, vis", "linear maps of OF Real-sim, both"):
        assert text(SHARES["of-real", f"{what}, with its whole profile"], 0) in PAGE
    for head in ("shipped head (TAG-sim)", "linear maps of TAG-sim"):
        readings = [
            (view, how)
            for view in ("vis", "tac", "both")
            for how in ("as they come", "with its whole profile")
        ]
        cells = [
            f"{100 * SHARES['of-real', f'{head}, {view}, {how}']['value']:.0f}"
            for view, how in readings
        ]
        assert f"| {' | '.join(cells)} |" in PAGE


def test_distances_are_those_of_the_record():
    for half in ("tac", "vis"):
        simulated = [
            gap for (modality, one, other), gap in GAPS.items()
            if modality == half and one != other and one.endswith("-sim") and other.endswith("-sim")
        ]  # fmt: skip
        assert f"{median(simulated):.2f} [{min(simulated):.2f}, {max(simulated):.2f}]" in PAGE
        for real, own in (("TAG, real", "TAG-sim"), ("OF Real, real", "OF Real-sim")):
            assert f"{GAPS[half, own, real]:.2f}" in PAGE
    others = {
        one: gap
        for (half, one, other), gap in GAPS.items()
        if half == "tac" and other == "TAG, real"
    }
    assert min(others, key=others.get) == "TAG-sim"
    for place in ("OF Real, real", "Octopi", "Billets"):
        filled = (
            f"{GAPS['tac', name, place]:.2f}" for name in ("TAG, real", "TAG, real, dots filled")
        )
        assert " to ".join(filled) in PAGE


def test_the_page_is_short():
    assert len(PAGE.split()) <= 1200
