"""The exit code of `python -m benchmarks.stability` shows whether every target is met."""

from pathlib import Path

import pytest
import torch

from benchmarks import stability


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stability, "QUICK", (4, 12))
    monkeypatch.setattr(stability, "STEPS", 20)
    monkeypatch.setattr(stability, "plot", lambda cells, path: None)


def test_it_exits_with_zero_when_all_targets_are_met(tmp_path: Path) -> None:
    assert stability.main(["--quick", "--out", str(tmp_path)]) == 0
    assert "**no**" not in (tmp_path / "stability.md").read_text()


def test_it_exits_with_one_and_names_the_cell_when_a_target_is_missed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(stability.REFERENCE, torch.float64, 1e-20)
    assert stability.main(["--quick", "--out", str(tmp_path)]) == 1
    assert "**no**" in (tmp_path / "stability.md").read_text()
    assert "missed: Cell(check='p between', size=12, dtype='float64'" in capsys.readouterr().err


def test_an_error_that_is_no_number_misses_its_target(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stability, "relative", lambda found, exact: torch.nan)
    assert stability.main(["--quick", "--out", str(tmp_path)]) == 1
