"""The progress of long commands in a log."""

import pytest

from omnivat.cli import arguments
from omnivat.kit.progress import Step


@pytest.fixture
def clock(monkeypatch):
    """Return a list whose only entry is the time."""
    now = [0.0]
    monkeypatch.setattr(arguments.time, "monotonic", lambda: now[0])
    return now


def written(capsys, clock, steps, seconds):
    with arguments.progress_bar("train") as show:
        for done in range(1, steps + 1):
            clock[0] += seconds
            show(Step(done=done, total=steps, text=f"epoch {done}"))
    return capsys.readouterr().err.splitlines()


def test_a_log_has_a_line_for_every_tenth_with_the_time_left(capsys, clock):
    lines = written(capsys, clock, 100, 5.0)
    assert len(lines) == 10
    assert lines[1] == "train: 20 %, 20 of 100, 6 min 40 s left, epoch 20"


def test_short_work_writes_nothing_into_a_log(capsys, clock):
    assert written(capsys, clock, 100, 0.01) == []


def test_slow_work_writes_before_its_next_tenth(capsys, clock):
    assert len(written(capsys, clock, 20, 61.0)) == 20


def test_a_second_stage_starts_its_time_again(capsys, clock):
    with arguments.progress_bar("sweep") as show:
        for done in (1, 5, 10, 1, 5, 10):
            clock[0] += 10
            show(Step(done=done, total=10))
    lines = capsys.readouterr().err.splitlines()
    shares = [line.split(",")[0] for line in lines]
    assert shares == ["sweep: 50 %", "sweep: 100 %"] * 2


@pytest.mark.parametrize(
    "words",
    [
        ["gaps", "--stage", "raw"],
        ["project", "--stage", "raw", "--method", "pca", "--out", "OUT/map.csv"],
        ["evaluate", "--head", "HEAD"],
    ],
    ids=lambda words: words[0],
)
def test_a_command_that_walks_a_set_reports_all_of_it(words, head_folder, tmp_path, monkeypatch):
    from contextlib import contextmanager
    from importlib import import_module

    seen = []

    @contextmanager
    def bar(title):
        yield seen.append

    for module in ("features", "evaluate"):
        monkeypatch.setattr(import_module(f"omnivat.cli.{module}"), "progress_bar", bar)
    places = {"HEAD": str(head_folder), "OUT": str(tmp_path)}
    words = [places.get(word, word.replace("OUT", str(tmp_path))) for word in words]
    file = head_folder.parent / "set.safetensors"
    assert import_module("omnivat.cli").main([*words, "--embeddings", str(file)]) == 0
    assert seen and seen[-1].total > 0 and seen[-1].done >= seen[-1].total - 1
