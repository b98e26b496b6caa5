"""Time a call and describe the machine: shared by the benchmarks."""

import os
import platform
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any

import torch


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """Seconds of several runs: median, lowest and highest, of CPU and of the wall clock."""

    runs: int
    cpu: float
    cpu_low: float
    cpu_high: float
    wall: float
    wall_low: float
    wall_high: float

    def __str__(self) -> str:
        return (
            f"wall {self.wall:.2f} s ({self.wall_low:.2f} to {self.wall_high:.2f}), "
            f"CPU {self.cpu:.2f} s ({self.cpu_low:.2f} to {self.cpu_high:.2f}), {self.runs} runs"
        )


def timed(call: Callable[[], Any], runs: int) -> Timing:
    """Run `call` a few times and return the seconds. The caller warms up first if needed."""
    cpu, wall = [], []
    for _ in range(runs):
        cpu_before, wall_before = time.process_time(), time.perf_counter()
        call()
        cpu.append(time.process_time() - cpu_before)
        wall.append(time.perf_counter() - wall_before)
    return Timing(
        runs=runs,
        cpu=statistics.median(cpu),
        cpu_low=min(cpu),
        cpu_high=max(cpu),
        wall=statistics.median(wall),
        wall_low=min(wall),
        wall_high=max(wall),
    )


def machine() -> dict[str, Any]:
    """Return a description of the machine and the versions."""
    return {
        "machine": f"{os.cpu_count()}-core {platform.machine()} CPU",
        "load": round(os.getloadavg()[0], 2),
        "threads": torch.get_num_threads(),
        "python": platform.python_version(),
        "torch": version("torch"),
    }


def as_dict(timing: Timing) -> dict[str, float]:
    """Return a timing for a JSON file."""
    return asdict(timing)
