"""How vectors are carried to the eigenbasis and back: one class for each way to cut V into blocks.

Every split offers the same two maps on rows, V orthogonal and real:
`analyse(x, out)` is out = x V on (R, N), `restore(z, out)` is out = z Vᵀ on (..., N), z used up.
Columns of V stand in the order of `indices`, which differs between the splits.
"""

from __future__ import annotations

from typing import Protocol

import torch
from torch import Tensor


class Split(Protocol):
    """V, cut into blocks, on one device and in one precision."""

    indices: Tensor
    """k of every column, (N,) float64."""

    def analyse(self, x: Tensor, out: Tensor) -> None:
        """out (R, N) = x (R, N) V."""

    def restore(self, z: Tensor, out: Tensor) -> None:
        """out (..., N) = z (..., N) Vᵀ; z is contiguous and overwritten, out may be z itself."""


class PlainSplit:
    """V whole, for N so small that halves would be empty."""

    def __init__(self, vectors: Tensor, indices: Tensor) -> None:
        self.vectors, self.indices = vectors, indices

    def analyse(self, x: Tensor, out: Tensor) -> None:
        torch.mm(x, self.vectors, out=out)

    def restore(self, z: Tensor, out: Tensor) -> None:
        out.copy_(z @ self.vectors.T)


class HalfSplit:
    """Even and odd vectors apart: two blocks of N/2, half the work of V.

    even (N//2+1, N//2+1), odd ((N-1)//2, (N-1)//2): the first half of the samples of the
    eigenvectors, columns by rising k. A sample and its mirror image are both read off one row.
    """

    def __init__(self, even: Tensor, odd: Tensor, indices: Tensor) -> None:
        self.even, self.odd, self.indices = even, odd, indices

    def analyse(self, x: Tensor, out: Tensor) -> None:
        size, half, paired = x.shape[-1], len(self.even), len(self.odd)
        mirrored = x[:, size - paired :].flip(-1)
        sums = x[:, :half].clone()
        sums[:, 1 : paired + 1] += mirrored
        torch.mm(sums, self.even, out=out[:, :half])
        torch.mm(x[:, 1 : paired + 1] - mirrored, self.odd, out=out[:, half:])

    def restore(self, z: Tensor, out: Tensor) -> None:
        size, half, paired = z.shape[-1], len(self.even), len(self.odd)
        even = z[..., :half] @ self.even.T
        odd = z[..., half:] @ self.odd.T
        out[..., :half] = even
        out[..., 1 : paired + 1] += odd
        out[..., size - paired :] = (even[..., 1 : paired + 1] - odd).flip(-1)
