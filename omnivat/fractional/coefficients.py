"""What is kept of a vector while the order moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import torch
from torch import Tensor

from omnivat.errors import ShapeError


@dataclass(frozen=True, eq=False)
class Coefficients:
    """The vectors of a tensor in the eigenbasis of the transform.

    values (..., N): coefficients, transformed axis last; real for real input, else complex.
    dim: where the transformed axis stood, counted from the end (-1 is the last axis).
    """

    values: Tensor
    dim: int = -1
    centered: bool = False

    @property
    def shape(self) -> torch.Size:
        """The leading axes: the shape of the batch, without the transformed axis."""
        return self.values.shape[:-1]

    @property
    def size(self) -> int:
        """N, the length of the transformed axis."""
        return self.values.shape[-1]

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, index: Any) -> Coefficients:
        """Choose along the leading axes only; the transformed axis stays whole."""
        parts = index if isinstance(index, tuple) else (index,)
        if not any(part is Ellipsis for part in parts):
            parts = (*parts, Ellipsis)
        return replace(self, values=self.values[(*parts, slice(None))])

    def to(self, *args: Any, **kwargs: Any) -> Coefficients:
        """The same coefficients on another device or in another precision (as Tensor.to)."""
        return replace(self, values=self.values.to(*args, **kwargs))

    def detach(self) -> Coefficients:
        """The same coefficients, cut from the graph."""
        return replace(self, values=self.values.detach())

    @staticmethod
    def cat(parts: Sequence[Coefficients]) -> Coefficients:
        """Join along the first leading axis.

        Raises ShapeError where lengths, axes or centring differ.
        """
        if len({(part.size, part.dim, part.centered) for part in parts}) != 1:
            sizes = sorted({part.size for part in parts})
            raise ShapeError(
                f"Coefficients of lengths {sizes} cannot be joined: "
                "they need one length, one axis and one centring."
            )
        return replace(parts[0], values=torch.cat([part.values for part in parts]))
