"""Sets of pairs and their summary."""

from pathlib import Path

import pytest

from omnivat.data.pairs import Pair, PairSet, Skipped, summary_table
from omnivat.kit.errors import DataError, MissingNameError, printable


def pair(material, domain="TAG", **names):
    return Pair(vis=Path("v.png"), tac=Path("t.png"), domain=domain, material=material, **names)


FOUND = PairSet(
    pairs=(
        pair("felt", split="train"),
        pair("wood", split="train", object="chair"),
        pair("wood", split="test", object="chair"),
        pair("glass", domain="TQ-DIGIT", part="indoor"),
    ),
    skipped=(
        Skipped(what="a", why="no half", count=1200),
        *(Skipped(what=name, why="no half") for name in "bcd"),
        Skipped(what="e", why="label -1"),
    ),
    origin="a test",
)


def test_the_summary_names_every_column_and_counts_every_pair():
    assert summary_table(FOUND).split("\n") == [
        "4 pairs from a test",
        "domain    part    split  wood  glass  felt  pairs  objects",
        "TAG       -       train  1     0      1     2      2",
        "TAG       -       test   1     0      0     1      1",
        "TQ-DIGIT  indoor  -      0     1      0     1      1",
        "no class is in two domains, so none is tested across domains; if your folders are"
        " classes, put them into one folder, which names their domain",
        "2 pairs name no object, and others do; each counts as its own object",
        "objects in more than one split: 1, such as 'chair'",
        "",
        "skipped  why       for example",
        "1203     no half   a; b; c; and 1 more",
        "1        label -1  e",
    ]


def test_the_summary_says_what_is_simulated():
    assert (
        summary_table(PairSet(pairs=(), origin="x", simulated=True)) == "0 pairs from x (simulated)"
    )


def test_odd_names_are_written_as_escapes():
    assert printable("a\nb\x1b\udcff\u200b é木") == "a\\nb\\x1b\\udcff\\u200b é木"
    assert len(summary_table(PairSet(pairs=(pair("wo\nod"),))).split("\n")) == 3


@pytest.mark.parametrize("kind", [DataError, MissingNameError])
def test_an_error_can_be_printed_whatever_it_quotes(kind):
    said = str(kind("No class is called 'a\x00\nb\u202e\udcff'."))
    assert said == "No class is called 'a\\x00\\nb\\u202e\\udcff'."
    assert said.isprintable()
