"""Worker processes of a killed command end, too."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from time import monotonic, sleep

import pytest

ROOT = Path(__file__).resolve().parents[3]
SCRIPT = """
import os, sys
from types import ModuleType
sys.modules["torch"] = ModuleType("torch")  # which takes two seconds to load, and is not needed
from omnivat.kit.threads import in_processes

def number(_):
    return os.getpid()

if __name__ == "__main__":
    for worker in in_processes(number, [0], 1):
        print(worker, flush=True)
        input()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signal")
def test_the_workers_of_a_killed_process_end(tmp_path):
    (tmp_path / "work.py").write_text(SCRIPT)
    environ = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(
        [sys.executable, tmp_path / "work.py"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environ,
    )
    worker = int(process.stdout.readline())
    process.kill()
    process.wait()
    until = monotonic() + 120
    while alive(worker) and monotonic() < until:
        sleep(0.05)
    lives = alive(worker)
    if lives:
        os.kill(worker, signal.SIGKILL)
    process.communicate()
    assert not lives


def alive(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    state = Path(f"/proc/{number}/stat")
    return not state.exists() or state.read_text().rsplit(")", 1)[1].split()[0] != "Z"
