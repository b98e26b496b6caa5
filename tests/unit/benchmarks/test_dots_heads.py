"""Heads that learned dots kept, filled or on half of a source's touches, in tables."""

from benchmarks.dots_heads import cells, table


def line(source: str, learned: str, tested: str, right: float, *, printed: bool) -> dict:
    one = {"photo": [right] * 7, "touch": [right] * 7, "both": [right] * 7}
    rungs = {"home": {n: [right] for n in one}, "none": one, "n5": one, "n20": one, "k5": one}
    where = {"method": "OmniVaT", "source": source, "learned": learned, "tested": tested}
    return {**where, "printed": printed, **rungs}


LINES = [
    line("A", "filled", "filled", 70, printed=True),
    line("A", "kept", "kept", 50, printed=True),
    line("B", "filled", "filled", 80, printed=False),
    line("B", "filled", "kept", 60, printed=False),
]


def test_a_source_without_dots_has_learned_the_same_where_dots_are_kept() -> None:
    found = cells(LINES, "OmniVaT", "kept", "kept", ("none", "touch"), ["A", "B"])
    assert found.shape == (2, 7, 1) and found[:, 0, 0].tolist() == [50, 60]


def test_a_row_that_a_source_lacks_has_no_figure() -> None:
    rows = list(table(LINES))
    assert any(row.startswith("| OmniVaT | both | 55.0 → 75.0") and "+20.0" in row for row in rows)
    assert "| OmniVaT without MFFA | 0 | – | – | – | – |" in rows
    assert not any(row.startswith("| ERM-MLP | both") for row in rows)
