"""Build splits of V in float64, cast them, and keep the most recently used ones."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from jaxtyping import Float64, Inexact
from torch import Tensor

from omnivat.fractional.commuting import Tridiagonal, parity_blocks
from omnivat.fractional.eigenvectors import refined_quarter, refined_spectrum
from omnivat.fractional.splits import HalfSplit, QuarterSplit, Split, kept_numbers
from omnivat.fractional.workers import side_by_side
from omnivat.kit.threads import one_blas_thread

_KEPT = 16

_building = threading.RLock()


def indices_by_parity(size: int) -> Float64[np.ndarray, " {size}"]:
    """Return k of the even and of the odd eigenvectors; for even N, N replaces N - 1."""
    even, odd = np.arange(size // 2 + 1), np.arange((size - 1) // 2)
    return np.concatenate([2 * even, 2 * odd + 1]).astype(np.float64)


def build_split(size: int, like: Tensor) -> Split:
    """Build the cheapest split for length N, on the device and in the precision of `like`."""
    quarters = size % 4 == 0 and size > 4
    refine: Callable[[Tridiagonal], Any] = refined_quarter if quarters else refined_spectrum
    # each parity has a core: identical to the last bit for any number of threads
    with one_blas_thread():
        even, odd = side_by_side([functools.partial(refine, b) for b in parity_blocks(size)])
    if quarters:
        return QuarterSplit(even, odd, like)
    if size == 2:  # both neighbours of a sample are the other one: the block has another form
        cosine, sine = np.cos(np.pi / 8), np.sin(np.pi / 8)
        even = np.array([[cosine, sine], [sine, -cosine]])
    even[1 : (size + 1) // 2] *= np.sqrt(0.5)  # every sample but 0 and N/2 has a mirror image
    indices = torch.from_numpy(indices_by_parity(size)).to(like.device)
    halves = [torch.from_numpy(half).to(like) for half in (even, odd * np.sqrt(0.5))]
    return HalfSplit(halves[0], halves[1], indices)


@functools.lru_cache(maxsize=_KEPT)
def _built(size: int, dtype: torch.dtype, device: torch.device) -> Split:
    with kept_numbers():
        return build_split(size, torch.empty(0, dtype=dtype, device=device))


def split_for(values: Inexact[Tensor, "... N"]) -> Split:
    """Return the split for the last axis, the precision and the device of `values`."""
    with _building:  # else two threads could build the same split
        return _built(values.shape[-1], values.dtype.to_real(), values.device)
