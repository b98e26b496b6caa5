"""Compare calls fairly on a shared machine: interleaved rounds, medians, the machine's rate."""

from __future__ import annotations

import os
import platform
import random
import statistics
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import torch
from torch import Tensor

SHORTEST = 0.02  # seconds


@dataclass(frozen=True, slots=True)
class Spread:
    """Milliseconds of several runs: median, lowest and highest."""

    median: float
    low: float
    high: float
    runs: int


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Let torch use `count` threads inside."""
    before = torch.get_num_threads()
    torch.set_num_threads(count)
    try:
        yield
    finally:
        torch.set_num_threads(before)


def interleaved(
    calls: Mapping[str, Callable[[], Any]], rounds: int, cpu: bool = False
) -> dict[str, Spread]:
    """Time each call in every round, in a new random order, after one warm-up call.

    Other load and the state of the caches then affect all calls equally. A call is repeated for at
    least SHORTEST seconds and the mean counts, because a single call of half a millisecond would
    measure cold caches. cpu: use this process's CPU seconds, correct for one thread; else wall
    time.
    """
    clock = time.process_time if cpu else time.perf_counter
    taken: dict[str, list[float]] = {name: [] for name in calls}
    for call in calls.values():
        call()
    names, draw = list(calls), random.Random(0)
    for _ in range(rounds):
        draw.shuffle(names)
        for name in names:
            start, count, passed = clock(), 0, 0.0
            while passed < SHORTEST:
                calls[name]()
                count, passed = count + 1, clock() - start
            taken[name].append(1e3 * passed / count)
    return {
        name: Spread(statistics.median(times), min(times), max(times), len(times))
        for name, times in taken.items()
    }


def product_call() -> tuple[Callable[[], Tensor], float]:
    """Return a product of two 1024 × 1024 matrices of float32 as a reference, and its number of
    operations.
    """
    a, b, out = torch.randn(3, 1024, 1024)
    return (lambda: torch.mm(a, b, out=out)), 2.0 * 1024**3


def machine() -> dict[str, Any]:
    """Return a description of the machine and the versions."""
    return {
        "machine": f"{os.cpu_count()}-core {platform.machine()} CPU",
        "load": round(os.getloadavg()[0], 2),
        "threads": torch.get_num_threads(),
        "python": platform.python_version(),
        "torch": version("torch"),
    }
