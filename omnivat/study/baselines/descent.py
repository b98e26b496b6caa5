"""Minibatch gradient descent for the baselines: by default a warm-up, then cosine to zero."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import torch
from torch import Tensor, nn

from omnivat.kit.seeding import derive_seed
from omnivat.study.baselines.contract import Source, seeded

M = TypeVar("M", bound=nn.Module)


@dataclass(frozen=True, slots=True, kw_only=True)
class Descent:
    """Settings of the descent. SGD has momentum 0.9; "adam" is AdamW."""

    lr: float
    epochs: int = 20
    batch: int = 16
    weight_decay: float = 5e-4
    method: str = "sgd"
    warmup: float = 0.05  # share of all steps
    cosine: bool = True  # else the rate stays
    clip: float = 5.0  # of the gradient's norm; 0 leaves it out
    eps: float = 1e-8  # of AdamW


def learned(
    source: Source,
    build: Callable[[], M],
    how: Descent,
    loss: Callable[[M, Tensor], Tensor],
    *stream: str,
) -> M:
    """Return a module trained on a source, frozen; its weights and batches are drawn from `stream`.

    loss  (module, rows (B,) of the pairs of a step) -> () to minimise
    """
    with seeded(derive_seed(source.seed, *stream)):
        module = build()
        descend(module, len(source), how, partial(loss, module))
    return module.requires_grad_(False)


def size(module: nn.Module) -> int:
    """Return the number of a module's parameters."""
    return sum(weight.numel() for weight in module.parameters())


def descend(module: nn.Module, count: int, how: Descent, loss: Callable[[Tensor], Tensor]) -> None:
    """Train `module` in place on `count` pairs.

    loss   (rows (B,) of the pairs of a step) -> () to minimise
    It uses torch's random stream, so call it inside `seeded`.
    """
    optimiser: torch.optim.Optimizer
    if how.method == "adam":
        optimiser = torch.optim.AdamW(
            module.parameters(), weight_decay=how.weight_decay, eps=how.eps, fused=True
        )
    else:
        optimiser = torch.optim.SGD(
            module.parameters(), momentum=0.9, weight_decay=how.weight_decay
        )
    total = how.epochs * math.ceil(count / how.batch)
    step = 0
    module.train()
    for _ in range(how.epochs):
        for rows in torch.split(torch.randperm(count), how.batch):
            for group in optimiser.param_groups:
                group["lr"] = how.lr * (rate(step, total, how.warmup) if how.cosine else 1.0)
            optimiser.zero_grad(set_to_none=True)
            loss(rows).backward()
            if how.clip:
                torch.nn.utils.clip_grad_norm_(module.parameters(), how.clip)
            optimiser.step()
            step += 1
    module.eval()


def rate(step: int, total: int, warmup: float) -> float:
    """Return the factor of the learning rate at a step: linear warm-up, then cosine."""
    warm = max(1, round(warmup * total))
    if step < warm:
        return (step + 1) / warm
    return 0.5 * (1 + math.cos(math.pi * (step - warm) / max(1, total - warm)))
