"""SGD with momentum, step for step as `torch.optim.SGD(fused=True)`."""

from collections.abc import Iterator
from typing import Any

import torch
from torch import Tensor


class Momentum:
    """SGD with momentum in groups of parameters.

    torch's own class loads its compiler at the first use: 0.9 s and 74 MB.

    param_groups  each with "params", "weight_decay" and "lr"
    buffers       the momentum of each parameter that has had a gradient
    """

    def __init__(self, param_groups: list[dict[str, Any]], momentum: float) -> None:
        self.param_groups, self.momentum = param_groups, momentum
        self.buffers: dict[Tensor, Tensor] = {}

    @property
    def parameters(self) -> Iterator[Tensor]:
        """All parameters, group by group."""
        return (parameter for group in self.param_groups for parameter in group["params"])

    @torch.no_grad()
    def step(self) -> None:
        """Move each parameter that has a gradient; the first momentum of one is its gradient."""
        for group in self.param_groups:
            alike: dict[tuple[Any, ...], list[Tensor]] = {}
            for one in group["params"]:
                if one.grad is not None:
                    alike.setdefault((one.device, one.dtype, one not in self.buffers), []).append(one)
            for (_, _, first), these in alike.items():
                slopes = [one.grad for one in these if one.grad is not None]
                if first:
                    self.buffers |= {one: torch.empty_like(slope) for one, slope in zip(these, slopes, strict=True)}
                torch._fused_sgd_(
                    these,
                    slopes,
                    [self.buffers[one] for one in these if self.momentum],  # none without momentum
                    weight_decay=group["weight_decay"],
                    momentum=self.momentum,
                    lr=group["lr"],
                    dampening=0.0,
                    nesterov=False,
                    maximize=False,
                    is_first_step=first,
                )
