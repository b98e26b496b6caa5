"""The exit code of `python -m benchmarks.stability` shows whether every target is met."""

import pytest
import torch

from benchmarks import stability


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    monkeypatch.setattr(stability, "QUICK", (4, 12))
    monkeypatch.setattr(stability, "STEPS", 20)


def test_it_exits_with_one_and_names_the_cell_when_a_target_is_missed(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setitem(stability.REFERENCE, torch.float64, 1e-20)
    assert stability.main(["--quick", "--out", str(tmp_path / "record.json")]) == 1
    printed = capsys.readouterr()
    assert "**no**" in printed.out
    assert "missed: Cell(check='p between', size=12, dtype='float64'" in printed.err
