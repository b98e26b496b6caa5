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

    @property
    def size(self) -> int:
        """N, the length of the transformed axis."""
        return self.values.shape[-1]

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, index: Any) -> Coefficients:
        """Index the leading axes; the transformed axis stays whole and in its place.

        Raises ShapeError for several tensors or lists at once if axes follow the transformed one.
        """
        parts = index if isinstance(index, tuple) else (index,)
        if not any(part is Ellipsis for part in parts):
            parts = (*parts, Ellipsis)
        dim = -1 if self.dim == -1 else -1 - _axes_left(parts, self.shape, after=-1 - self.dim)
        return replace(self, values=self.values[(*parts, slice(None))], dim=dim)

    def to(self, *args: Any, **kwargs: Any) -> Coefficients:
        """The same coefficients on another device or in another precision (as Tensor.to)."""
        return replace(self, values=self.values.to(*args, **kwargs))

    def detach(self) -> Coefficients:
        """The same coefficients, detached from the graph."""
        return replace(self, values=self.values.detach())


def _axes_left(parts: tuple[Any, ...], shape: torch.Size, *, after: int) -> int:
    """Return how many of the last `after` leading axes an index keeps, including new ones.

    parts  an index of the leading axes `shape` with one Ellipsis
    """
    tables = [part for part in parts if isinstance(part, Tensor | list)]
    if len(tables) > 1:
        raise ShapeError(
            f"The index holds {len(tables)} tensors or lists, expected one at most where axes"
            " follow the transformed one: index one axis after the other."
        )
    used = sum(_consumed(part) for part in parts)
    axis, kept = 0, 0
    for part in parts:
        step = len(shape) - used if part is Ellipsis else _consumed(part)
        inside = min(max(axis + step - (len(shape) - after), 0), step)  # axes after it
        if part is Ellipsis:
            kept += inside
        elif part is None:
            kept += axis > len(shape) - after
        elif isinstance(part, slice):
            kept += inside
        elif isinstance(part, Tensor | list) and inside:
            if inside < step:
                raise ShapeError("One mask cannot span axes on both sides of the transformed one.")
            kept += 1 if _is_mask(part) else torch.as_tensor(part).dim()
        axis += step
    return kept


def _consumed(part: Any) -> int:
    """Return how many axes one part of an index covers; the part is not an Ellipsis."""
    if part is None or part is Ellipsis:
        return 0
    return torch.as_tensor(part).dim() if _is_mask(part) else 1


def _is_mask(part: Any) -> bool:
    return isinstance(part, Tensor | list) and torch.as_tensor(part).dtype == torch.bool
