"""Freed memory goes back to the system."""

import ctypes
import subprocess
import sys

import pytest

SCRIPT = """
import sys
from threading import Thread
from app.shared.memory import Trim, share_arenas

def resident():
    return int(open("/proc/self/statm").read().split()[1]) * 4096

share_arenas()
kept = []
def work():
    blocks = [bytes(100_000) for _ in range(1000)]  # below the size that glibc maps by itself
    kept.append(blocks[::100])  # what stays lies between what goes

before = resident()
for _ in range(4):
    thread = Thread(target=work)
    thread.start()
    thread.join()
held = resident() - before
trim = Trim(1.0)
for _ in range(3):
    trim.soon()
trim._pending.join()
print(held, resident() - before)
"""


@pytest.mark.skipif(
    not hasattr(ctypes.CDLL(None), "malloc_trim"), reason="memory of this system is not glibc's"
)
def test_what_work_frees_between_what_it_keeps_goes_back_to_the_system():
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True
    )
    held, after = map(int, done.stdout.split())
    assert after < held / 2, (held, after)
    assert after < 20_000_000  # four times 1 MB is kept


FAULTS = """
import resource
from threading import Thread
from app.shared.memory import share_arenas

def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt

def work():
    global before
    for turn in range(40):
        if turn == 10:
            before = faults()
        layers = [bytearray(size << 20) for size in (5, 2)]  # as an encoder's
        del layers

share_arenas()
thread = Thread(target=work)
thread.start()
thread.join()
print(faults() - before)
"""


@pytest.mark.skipif(
    not hasattr(ctypes.CDLL(None), "malloc_trim"), reason="memory of this system is not glibc's"
)
def test_memory_of_an_encoders_layers_is_used_again_without_new_pages():
    done = subprocess.run(
        [sys.executable, "-c", FAULTS], capture_output=True, text=True, check=True
    )
    assert int(done.stdout) < 30 * 1750 / 4  # 30 turns of 1,750 pages of 4 kB
