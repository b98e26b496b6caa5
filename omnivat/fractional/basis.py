"""The eigenbasis itself, for inspection and tests."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor

from omnivat.errors import ShapeError
from omnivat.fractional.batches import restore_rows
from omnivat.fractional.build import splits


class Basis(NamedTuple):
    """Eigenvectors of the DFT, (N, N), column c with eigenvalue exp(-iπk/2), k = indices[c] (N,)."""

    vectors: Tensor
    indices: Tensor


def basis(size: int, *, dtype: torch.dtype = torch.float64, device: torch.device | str = "cpu") -> Basis:
    """Return the Hermite-like eigenvectors of the DFT of length N, ordered by sign changes k.

    k = 0 … N-2 and N for even N, 0 … N-1 for odd N. The sign of each vector is arbitrary.
    The transform of order p is vectors · diag(exp(-iπp·indices/2)) · vectorsᵀ.

    Raises ShapeError when the size is below 1 or the dtype is not float32 or float64.
    """
    if size < 1 or dtype not in (torch.float32, torch.float64):
        raise ShapeError(
            f"A basis of size {size} in {dtype} was requested, expected a size of 1 or more "
            "in torch.float32 or torch.float64."
        )
    split = splits.get(size, dtype, torch.device(device))
    rows = restore_rows(split, torch.eye(size, dtype=dtype, device=device))
    indices, order = split.indices.sort()
    return Basis(rows[order].T.contiguous(), indices)
