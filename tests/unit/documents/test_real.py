"""docs/real.md states what its record holds."""

import json
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
RECORDS = json.loads((ROOT / "docs/benchmarks/real.json").read_text(encoding="utf-8"))["records"]
PAGE = (ROOT / "docs/real.md").read_text(encoding="utf-8").replace("**", "").replace("−", "-")
SHARES = {(one["part"], one["what"]): one for one in RECORDS if one["part"] != "distance"}


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
