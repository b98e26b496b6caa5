"""Compare calls fairly on a shared machine: interleaved rounds, medians, the machine's own rate."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor


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
    """Time each call once a round, all calls in every round, after one call to warm up.

    What disturbs the machine so falls on all alike. cpu: count this process's seconds on the
    processor, right for one thread; else those of the wall clock.
    """
    clock = time.process_time if cpu else time.perf_counter
    taken: dict[str, list[float]] = {name: [] for name in calls}
    for call in calls.values():
        call()
    for _ in range(rounds):
        for name, call in calls.items():
            start = clock()
            call()
            taken[name].append(1e3 * (clock() - start))
    return {
        name: Spread(statistics.median(times), min(times), max(times), len(times))
        for name, times in taken.items()
    }


def product_call(
    width: int = 1024, dtype: torch.dtype = torch.float32
) -> tuple[Callable[[], Tensor], float]:
    """A square matrix product to time among others, and its number of operations."""
    a, b = torch.randn(width, width, dtype=dtype), torch.randn(width, width, dtype=dtype)
    out = torch.empty_like(a)
    return (lambda: torch.mm(a, b, out=out)), 2.0 * width**3
