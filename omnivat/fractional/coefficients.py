"""The coefficients of vectors, which do not depend on the order."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import torch
from jaxtyping import Inexact
from torch import Tensor

from omnivat.kit.errors import ShapeError


@dataclass(frozen=True, eq=False)
class Coefficients:
    """The vectors of a tensor in the eigenbasis of the transform.

    values: transformed axis last; real for real input, else complex.
    dim: position of the transformed axis in the input, counted from the end (-1 is the last).
    """

    values: Inexact[Tensor, "... N"]
    dim: int = -1
    centered: bool = False

    @property
    def shape(self) -> torch.Size:
        """The leading axes: the shape of the batch, without the transformed axis."""
        return self.values.shape[:-1]

    def __getitem__(self, index: Any) -> Coefficients:
        """Index the leading axes; the transformed axis stays whole.

        Raises ShapeError if the transformed axis is not the last one of the input.
        """
        if self.dim != -1:
            raise ShapeError(
                f"Coefficients of axis {self.dim} cannot be indexed: index x before the transform,"
                " or move that axis to the end."
            )
        parts = index if isinstance(index, tuple) else (index,)
        if not any(part is Ellipsis for part in parts):
            parts = (*parts, Ellipsis)
        return replace(self, values=self.values[(*parts, slice(None))])
