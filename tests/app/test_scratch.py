"""The server's temporary folder: gone with the server, or swept by the next one."""

import subprocess
import sys
from pathlib import Path

import pytest

from app.shared import scratch
from app.shared.scratch import sweep

ROOT = Path(__file__).resolve().parents[2]
MAKES = """
import sys, time
from app.shared.scratch import Scratch
home = Scratch()
print(home.folder("x"), flush=True)
{then}
"""


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(scratch, "gettempdir", lambda: str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def process(then):
    return subprocess.Popen(
        [sys.executable, "-c", MAKES.format(then=then)], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )


def test_what_a_killed_process_left_is_swept_and_what_a_living_one_uses_stays(elsewhere):
    killed, alive = process("time.sleep(600)"), process("time.sleep(600)")
    left, used = (Path(one.stdout.readline().strip()) for one in (killed, alive))
    killed.kill()
    killed.wait()
    try:
        assert sweep() == 1
        assert not left.exists()
        assert used.is_dir()
    finally:
        alive.kill()
        alive.communicate()
        killed.communicate()


def test_folders_of_other_names_are_never_swept(elsewhere):
    (elsewhere / "omnivat-other").mkdir()
    (elsewhere / "omnivat-page-without-a-lock").mkdir()
    assert sweep() == 0
    assert len(list(elsewhere.iterdir())) == 2
