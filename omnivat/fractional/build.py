"""Build splits of V in float64, cast them, and cache a bounded number of them."""

from __future__ import annotations

import functools
import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import TypeVar

import numpy as np
import torch
from jaxtyping import Float64
from torch import Tensor

from omnivat.fractional.commuting import ParityBlocks, Tridiagonal, parity_blocks
from omnivat.fractional.eigenvectors import refined_quarter, refined_spectrum
from omnivat.fractional.splits import HalfSplit, PlainSplit, QuarterSplit, Split, kept_numbers
from omnivat.fractional.workers import side_by_side
from omnivat.kit.threads import one_blas_thread

_TINY = 3
_KEPT = 16
_WORTH_THREADS = 128  # size of a parity block; smaller ones are not worth a second thread

T = TypeVar("T")


def indices_by_parity(size: int) -> Float64[np.ndarray, " {size}"]:
    """Return k of the even and of the odd eigenvectors; for even N, N replaces N - 1."""
    even, odd = np.arange(size // 2 + 1), np.arange((size - 1) // 2)
    return np.concatenate([2 * even, 2 * odd + 1]).astype(np.float64)


def _tiny_vectors(size: int) -> Float64[np.ndarray, "{size} {size}"]:
    """Return V for N = 1, 2, 3 in closed form, columns as in `indices_by_parity`."""
    if size == 1:
        return np.ones((1, 1))
    if size == 2:
        angle = np.pi / 8
        return np.array([[np.cos(angle), np.sin(angle)], [np.sin(angle), -np.cos(angle)]])
    first = np.sqrt((1 + np.sqrt(1 / 3)) / 2)  # eigenvectors of the DFT itself: 2a² - 1 = 1/√3
    other = np.sqrt((1 - np.sqrt(1 / 3)) / 4)
    pair = np.sqrt(0.5)
    last = np.sqrt(2.0) * other, -first * pair
    return np.array([[first, last[0], 0.0], [other, last[1], pair], [other, last[1], -pair]])


def build_split(size: int, like: Tensor) -> Split:
    """Build the cheapest split for length N, on the device and in the precision of `like`."""
    if size <= _TINY:
        vectors = torch.from_numpy(_tiny_vectors(size)).to(like)
        return PlainSplit(vectors, torch.from_numpy(indices_by_parity(size)).to(like.device))
    # each parity has a core: identical to the last bit for any number of threads
    with one_blas_thread():
        blocks = parity_blocks(size)
        if size % 4 == 0 and size > 4:
            factors = _both(refined_quarter, blocks)
            return QuarterSplit(factors[0], factors[1], like)
        even, odd = _both(refined_spectrum, blocks)
    even[1 : (size + 1) // 2] *= np.sqrt(0.5)  # every sample but 0 and N/2 has a mirror image
    halves = [torch.from_numpy(half).to(like) for half in (even, odd * np.sqrt(0.5))]
    return HalfSplit(
        halves[0], halves[1], torch.from_numpy(indices_by_parity(size)).to(like.device)
    )


def _both(refine: Callable[[Tridiagonal], T], blocks: ParityBlocks) -> list[T]:
    """Compute even and odd eigenvectors in parallel; they are independent."""
    calls = [functools.partial(refine, block) for block in (blocks.even, blocks.odd)]
    return side_by_side(calls, spread=len(blocks.even) > _WORTH_THREADS)


class BoundedCache:
    """The most recently used splits. Threads may share it; each split is built once, one at a
    time.
    """

    def __init__(self, build: Callable[[int, Tensor], Split], limit: int = _KEPT) -> None:
        self._build, self._limit = build, limit
        self._kept: OrderedDict[tuple[int, torch.dtype, torch.device], Split] = OrderedDict()
        self._lock, self._building = threading.Lock(), threading.RLock()

    def __len__(self) -> int:
        return len(self._kept)

    def clear(self) -> None:
        """Remove all splits."""
        with self._lock:
            self._kept.clear()

    def _find(self, key: tuple[int, torch.dtype, torch.device]) -> Split | None:
        with self._lock:
            found = self._kept.get(key)
            if found is not None:
                self._kept.move_to_end(key)
            return found

    def get(self, size: int, dtype: torch.dtype, device: torch.device) -> Split:
        """Return the split for that length, real precision and device; build it if needed."""
        key = (size, dtype, device)
        found = self._find(key)
        if found is None:
            with self._building:
                found = self._find(key)  # another thread may have built it meanwhile
                if found is None:
                    with kept_numbers():
                        found = self._build(size, torch.empty(0, dtype=dtype, device=device))
                    with self._lock:
                        self._kept[key] = found
                        if len(self._kept) > self._limit:
                            self._kept.popitem(last=False)
        return found


splits = BoundedCache(build_split)
