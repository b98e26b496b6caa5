"""The scripts in examples/ run unchanged and print the promised output."""

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


def test_the_raw_transform_moves_no_gap_and_the_head_does(capsys):
    runpy.run_path(str(FOLDER / "two_gaps.py"))
    rows = {line[:22].strip(): line[22:].split() for line in capsys.readouterr().out.splitlines()}
    raw = [float(value) for value in rows["modality_gap/frft"]]
    assert raw == pytest.approx([raw[0]] * 3, abs=2e-3)
    assert len(set(rows["modality_gap/f_hat"])) > 1
    assert float(rows["accuracy"][1]) > max(float(rows["accuracy"][0]), float(rows["accuracy"][2]))


def test_the_default_head_takes_the_step_of_heads_with_imitated_sensors():
    head = load_head(FOLDER / "head")
    assert head.provenance["train"]["shift"] and head.source_profile.step == STEP_SHIFTED


def test_every_script_is_run_here():
    text = Path(__file__).read_text(encoding="utf-8")
    assert all(script.name in text for script in FOLDER.glob("*.py"))
