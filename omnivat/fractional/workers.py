"""Process many pieces in parallel: one worker for each core, each with one torch thread.

Torch divides every operation among its threads and waits for all of them, about forty times for
each piece. Parallel pieces wait once, and each core keeps its piece in its own cache.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from typing import TypeVar

import torch

T = TypeVar("T")

_MOST = 8  # more would wait for Python's lock; torch then uses several threads in each worker

_pools: dict[int, ThreadPoolExecutor] = {}
_lock = threading.Lock()


def _forget() -> None:
    """Reset after a fork: the child has pools without threads, and perhaps a held lock."""
    global _lock
    _lock = threading.Lock()
    _pools.clear()


if hasattr(os, "register_at_fork"):  # not on Windows
    os.register_at_fork(after_in_child=_forget)


def _pool(count: int) -> ThreadPoolExecutor:
    """Return started workers for `count` torch threads."""
    with _lock:
        if count not in _pools:
            workers = min(count, _MOST)
            started = threading.Barrier(workers + 1)

            def start() -> None:
                torch.get_num_threads()  # a thread's first call copies the number of the process
                # for this thread only, but new threads would copy it: hence the reset below
                torch.set_num_threads(count // workers)
                started.wait()

            _pools[count] = ThreadPoolExecutor(workers, "fractional", initializer=start)
            for _ in range(workers):
                _pools[count].submit(int)
            started.wait()
            torch.set_num_threads(count)
        return _pools[count]


def side_by_side(calls: Sequence[Callable[[], T]]) -> list[T]:
    """Return the results of the calls, run in parallel if torch may use several threads."""
    count = torch.get_num_threads()
    if count == 1:
        return [call() for call in calls]
    pool = _pool(count)
    running = [pool.submit(call) for call in calls]
    wait(running)  # wait even if one fails: the others still write to the caller's tensors
    return [done.result() for done in running]


def for_each(work: Callable[[T], object], parts: Iterable[T], *, spread: bool) -> None:
    """Call `work` for every part, without a graph. No two parts may write to the same memory.

    spread: True if the work runs on the CPU and is long enough for several threads. The result of a
    part does not depend on the number of threads, to the last bit.
    """
    count = torch.get_num_threads()
    if not spread or count == 1:
        for part in parts:
            work(part)
        return
    source, one_at_a_time, inference = (
        iter(parts),
        threading.Lock(),
        torch.is_inference_mode_enabled(),
    )

    def drain() -> None:
        with torch.inference_mode(inference), torch.no_grad():
            while True:
                with one_at_a_time:
                    part = next(source, None)
                if part is None:
                    return
                work(part)

    side_by_side([drain] * min(count, _MOST))
