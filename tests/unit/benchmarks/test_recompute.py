"""README and documents agree with the records, by code that shares nothing with the reports."""

import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks import recompute, table_text
from omnivat.measure.ladder import recorded

ROOT = recompute.ROOT


@pytest.fixture
def changed(monkeypatch, tmp_path):
    """Return a function that changes the README and returns what a check then calls wrong."""

    def wrong(change, check):
        text = (ROOT / "README.md").read_text(encoding="utf-8")
        other = change(text)
        assert other != text
        (tmp_path / "README.md").write_text(other)
        (tmp_path / "docs").symlink_to(ROOT / "docs")
        monkeypatch.setattr(recompute, "ROOT", tmp_path)
        count = recompute.Count()
        check(count)
        return count.wrong

    return wrong


def test_every_figure_of_readme_and_documents_stands_in_a_record(capsys):
    with pytest.raises(SystemExit) as ended:
        recompute.main()
    text = capsys.readouterr().out
    assert not ended.value.code, text
    numbers = [int(line.split(": ")[1].split()[0]) for line in text.splitlines()]
    assert numbers[0] > 60 and numbers[1] > 60 and numbers[2:5] == [56, 6, 3] and numbers[5] > 60


def test_the_tables_of_readme_and_documents_are_those_of_the_record(monkeypatch):
    monkeypatch.setattr("sys.argv", ["table_text", "--check"])
    with pytest.raises(SystemExit) as ended:
        table_text.main()
    assert not ended.value.code, "run: python -m benchmarks.table_text"


def test_the_page_says_the_same_accuracies_as_the_tables():
    record = table_text.Record()
    rows = [one for source in record.domains for one in recorded(source, record.domains)]
    for rung in ("home", "none", "n5", "n20", "k5"):
        shown = [one["accuracy"] for one in rows if one["rung"] == rung]
        told = np.nanmean(np.nanmean(record.cells(rung)["omnivat"], axis=(1, 2)))
        assert len(shown) == 8
        assert 100 * np.mean(shown) == pytest.approx(told)


def test_a_speed_that_no_record_holds_is_named(changed):
    (wrong,) = changed(
        lambda text: text.replace("81× as fast", "83× as fast"), recompute.check_transform
    )
    assert "[16, 512]" in wrong


def test_the_script_imports_nothing_of_the_project():
    text = Path(recompute.__file__).read_text(encoding="utf-8")
    assert not re.findall(r"^(?:from|import) (?:omnivat|benchmarks)", text, re.MULTILINE)
