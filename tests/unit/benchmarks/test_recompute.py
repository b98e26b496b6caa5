"""The tables and the README agree with the records, by code that shares nothing with the reports."""

import ast
from pathlib import Path

import numpy as np
import pytest

from benchmarks import (
    _recompute_numbers,
    _recompute_order,
    _recompute_sets,
    ladder_check,
    ladder_sets_table,
    ladder_table,
    recompute,
)
from omnivat.data.packing import odds, unodds


def run(capsys):
    with pytest.raises(SystemExit) as ended:
        recompute.main()
    return ended.value.code, capsys.readouterr().out


def test_every_figure_of_the_tables_and_of_the_readme_stands_in_a_record(capsys):
    code, text = run(capsys)
    assert not code, text
    counts = [int(line.split(": ")[1].split()[0]) for line in text.splitlines()]
    assert (
        counts[0] > 2000
        and counts[1] > 1000
        and counts[2] > 300
        and counts[3] >= 42
        and counts[4] == 3
        and counts[5] == counts[6] == 6
        and counts[7] >= 14
        and counts[8] >= 216
        and counts[9:] == [143, 20, 16]
    )


def test_a_figure_that_no_record_holds_is_named(capsys, monkeypatch, tmp_path):
    readme = (recompute.ROOT / "README.md").read_text(encoding="utf-8")
    (tmp_path / "README.md").write_text(readme.replace("42.5 / 40.9", "43.5 / 40.9"))
    monkeypatch.setattr(recompute, "ROOT", tmp_path)
    count = recompute.Count()
    full = recompute.lines(recompute.RECORDS / "protocol_full.jsonl.gz")
    light = recompute.lines(recompute.RECORDS / "protocol.jsonl.gz")
    ours = [r for r in light if r["method"] == "omnivat" and not r["settings"]["train"]["noise"]]
    recompute.check_readme(count, full, ours)
    assert count.wrong == [next(w for w in count.wrong if w.startswith("README, OmniVaT, vis"))]


def test_an_interval_of_the_readme_that_no_report_has_is_named(monkeypatch, tmp_path):
    readme = (recompute.ROOT / "README.md").read_text(encoding="utf-8")
    (tmp_path / "README.md").write_text(readme.replace("[−5.1, 2.4]", "[−5.1, 2.3]"))
    monkeypatch.setattr(recompute, "ROOT", tmp_path)
    count = recompute.Count()
    recompute.check_printed(count)
    assert count.wrong == ["README: no report has -1.4 [-5.1, 2.3]"]


def test_a_figure_of_the_order_that_its_record_does_not_give_is_named(monkeypatch, tmp_path):
    text = (_recompute_order.DOCS / "order.md").read_text(encoding="utf-8")
    (tmp_path / "order.md").write_text(text.replace("+0.20 [-0.06, +0.46]", "+0.20 [-0.06, +0.45]"))
    (tmp_path / "benchmarks").symlink_to(_recompute_order.DOCS / "benchmarks")
    monkeypatch.setattr(_recompute_order, "DOCS", tmp_path)
    count = recompute.Count()
    _recompute_order.check_squares(count.compare)
    (wrong,) = count.wrong
    assert "trained', 'order', 64, 0.0" in wrong and "printed 0.45" in wrong


def test_the_script_imports_nothing_of_the_project():
    for module in (recompute, _recompute_numbers, _recompute_order, _recompute_sets, ladder_sets_table):
        tree = ast.parse(Path(module.__file__).read_text(encoding="utf-8"))
        names = {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
        names |= {a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}
        assert not [name for name in names if str(name).startswith("omnivat")]


def test_half_precision_keeps_probabilities_to_a_thousandth():
    logits = np.random.default_rng(0).normal(scale=4, size=(500, 5))
    shares = np.exp(logits) / np.exp(logits).sum(1, keepdims=True)
    assert np.abs(unodds(odds(logits), 5) - shares).max() < 2e-3
    same = recompute.probabilities({"odds": odds(logits)}, 5, 1.0)
    np.testing.assert_allclose(same, unodds(odds(logits), 5))


def test_the_ladder_with_its_intervals_is_what_its_records_give():
    found = ladder_table.shares(ladder_table.LADDERS)
    text = ladder_table.table(found, ladder_table.confidence(ladder_table.LADDERS))
    assert text + "\n" == (recompute.TABLES / "ladder.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("kind", ["as it is", "accuracy", "ECE"])
def test_plain_python_finds_the_ladders_figures_and_a_wrong_one(kind, capsys, monkeypatch, tmp_path):
    text = (recompute.TABLES / "ladder.md").read_text(encoding="utf-8")
    row = next(line for line in text.splitlines() if line.startswith("| one head | OmniVaT"))
    cells = row.split(" | ")
    place = {"as it is": 0, "accuracy": 2, "ECE": -2}[kind]
    if place:
        cells[place] = f"{float(cells[place]) + 0.3:.1f}"
    (tmp_path / "ladder.md").write_text(text.replace(row, " | ".join(cells)), encoding="utf-8")
    monkeypatch.setattr("sys.argv", ["ladder_check", "--table", str(tmp_path / "ladder.md")])
    with pytest.raises(SystemExit) as ended:
        ladder_check.main()
    assert bool(ended.value.code) == bool(place)
    assert ("OmniVaT, D = 64, budget" in capsys.readouterr().out) == bool(place)
