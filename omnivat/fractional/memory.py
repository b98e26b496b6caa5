"""A pool of memory blocks for large results, which avoids page faults.

A new tensor of 123 MB costs 40 ms of page faults, a third of the arithmetic that fills it. malloc
returns such memory to the system whenever it is freed, and sometimes smaller blocks, too (40 ms of
95 in forward + backward at 2000 × 512). Blocks of 1 MB and more are therefore mapped here. A block
is reused after the last tensor that shares it is gone; at most 256 MB stay idle. Rejected: huge
pages (0.2 s at first touch) and marking idle blocks as reclaimable (13 ms for each reuse).
"""

from __future__ import annotations

import math
import mmap
import threading
import weakref

import numpy as np
import torch
from torch import Tensor

_LARGE = 2**20
_IDLE_LIMIT = 256 * 2**20
_GRAIN = 2**20
_CAN_MAP = hasattr(mmap, "MAP_ANONYMOUS")  # not on Windows


class BlockPool:
    """Mapped blocks without a tensor, by size."""

    def __init__(self, idle_limit: int = _IDLE_LIMIT) -> None:
        self.idle_limit = idle_limit
        self._idle: list[mmap.mmap] = []
        self._lock = threading.RLock()  # a finalizer may run while the lock is held

    @property
    def idle_bytes(self) -> int:
        """Bytes mapped and unused."""
        return sum(map(len, self._idle))

    def clear(self) -> None:
        """Return all idle blocks to the system."""
        with self._lock:
            self._idle.clear()

    def take(self, size: int) -> mmap.mmap:
        """Return a block of `size` bytes, rounded up to megabytes, with arbitrary content."""
        size = math.ceil(size / _GRAIN) * _GRAIN
        with self._lock:
            for block in list(self._idle):
                # a finalizer may have dropped it in the meantime: try the next
                if len(block) == size and block in self._idle:
                    self._idle.remove(block)
                    return block
        return mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)

    def give_back(self, block: mmap.mmap) -> None:
        """Keep a block for reuse; drop the oldest idle blocks beyond the limit."""
        with self._lock:
            self._idle.append(block)
            while self.idle_bytes > self.idle_limit:
                self._idle.pop(0)


pool = BlockPool()


def empty(shape: tuple[int, ...], dtype: torch.dtype, device: torch.device) -> Tensor:
    """Same as torch.empty; large tensors in main memory come from the pool."""
    size = math.prod(shape) * dtype.itemsize
    if size < _LARGE or device.type != "cpu" or not _CAN_MAP:
        return torch.empty(shape, dtype=dtype, device=device)
    block = pool.take(size)
    owner = np.frombuffer(block, dtype=np.uint8, count=size)
    # The tensor's storage holds `owner`, so `owner` lives as long as the last view.
    weakref.finalize(owner, pool.give_back, block).atexit = False
    return torch.from_numpy(owner).view(dtype).view(shape)
