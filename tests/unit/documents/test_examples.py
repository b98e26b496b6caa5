"""The scripts in examples/ run unchanged and print the promised output."""

import re
import runpy
from pathlib import Path

import pytest

from omnivat.data.profile import STEP_SHIFTED
from omnivat.head.checkpoint import load_head

FOLDER = Path(__file__).resolve().parents[3] / "examples"


def test_the_step_keeps_its_length_at_every_order(capsys):
    runpy.run_path(str(FOLDER / "fractional_order.py"))
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 6
    assert {line.rpartition(" ")[2] for line in lines} == {"4.000000"}


def test_the_transform_moves_no_gap_and_the_steps_after_it_close_both(capsys):
    runpy.run_path(str(FOLDER / "two_gaps.py"))
    lines = capsys.readouterr().out.splitlines()
    for name in ("modality_gap", "domain_gap"):
        (line,) = (one for one in lines if one.startswith(name))
        raw, frft, *_, tree = (
            [float(end) for end in ends] for ends in re.findall(r"([\d.]+) to ([\d.]+)", line)
        )
        assert frft == pytest.approx([frft[0]] * 2, abs=2e-3)
        assert tree[1] < raw[0] - (tree[1] - tree[0])
    assert sum(line.count(", ") == 8 for line in lines) == 5  # two places and seven nodes a stop


def test_the_default_head_takes_the_step_of_heads_with_imitated_sensors():
    head = load_head(FOLDER / "head")
    assert head.provenance["train"]["shift"] and head.source_profile.step == STEP_SHIFTED


def test_every_script_is_run_here():
    text = Path(__file__).read_text(encoding="utf-8")
    assert all(script.name in text for script in FOLDER.glob("*.py"))
