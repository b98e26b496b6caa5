"""The transform as a layer with its own order."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor, nn

from omnivat.fractional.arguments import checked_order
from omnivat.fractional.transform import dfrft


class FractionalTransform(nn.Module):
    """`dfrft` with a learnable order.

    order: initial value, in quarter turns. For real input, the gradient of a modulus or a real part
    is exactly zero at 0 and 2, so do not start there. The order stays float64 when the layer is
    cast, because rounding it to float32 changes the result by 1e-5. learnable: True makes the
    order a parameter, False a buffer. dim, centered, planar: as in `dfrft`.
    """

    order: Tensor

    def __init__(
        self, order: float = 0.5, *, learnable: bool = True, dim: int = -1, centered: bool = False, planar: bool = False
    ) -> None:
        super().__init__()
        start = checked_order(order, torch.device("cpu"))
        if learnable:
            self.order = nn.Parameter(start)
        else:
            self.register_buffer("order", start)
        self.dim, self.centered, self.planar = dim, centered, planar

    def forward(self, x: Tensor) -> Tensor:
        """Transform x along `dim`; complex, or (2, ...) if `planar`."""
        return dfrft(x, self.order, self.dim, centered=self.centered, planar=self.planar)

    def extra_repr(self) -> str:
        """Return the text for `print(module)`."""
        return f"order={self.order.item():.6g}, dim={self.dim}, centered={self.centered}"

    def _apply(self, fn: Callable[[Tensor], Tensor], recurse: bool = True) -> FractionalTransform:
        """Move to another device, but keep the precision."""
        exact = self.order.detach().clone()
        super()._apply(fn, recurse)  # type: ignore[no-untyped-call]
        if self.order.dtype != torch.float64:
            self.order.data = exact.to(self.order.device)
            if self.order.grad is not None:
                self.order.grad.data = self.order.grad.double()
        return self
