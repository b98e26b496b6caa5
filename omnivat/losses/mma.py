"""Multimodal alignment (MMA) loss: it pulls VIS and TAC towards LANG."""

from typing import Any

import torch
from torch import Tensor
from torch.autograd.function import once_differentiable

from omnivat.shapes import require_shapes


def mma_loss(lang: Tensor, vis: Tensor | None = None, tac: Tensor | None = None) -> Tensor:
    """Multimodal alignment (MMA): KL(LANG || VIS) + KL(LANG || TAC), without the weight λ.

    lang, vis, tac  (B, D) features; a softmax over D makes each a distribution. An absent modality
                    (None) has no term
    return          () nats, >= 0, mean over the batch; 0 if they agree

    LANG is the reference, the first argument of the divergence. Gradients flow to all.
    Raises ShapeError if shapes differ.
    Source: paper, L_MMA.
    """
    others = {name: x for name, x in (("vis", vis), ("tac", tac)) if x is not None}
    require_shapes(lang=(lang, "B D"), **{name: (x, "B D") for name, x in others.items()})
    if not others:
        return lang.new_zeros(())
    total: Tensor = _Alignment.apply(torch.stack((lang, *others.values())))  # type: ignore[no-untyped-call]
    return total


class _Alignment(torch.autograd.Function):
    """KL from the first of (M, B, D) to each of the others, with a closed-form gradient."""

    @staticmethod
    def forward(ctx: Any, features: Tensor) -> Tensor:
        logs = torch.log_softmax(features, dim=-1)
        shares = logs.exp()
        excess = logs[0] * (len(logs) - 1) - logs[1:].sum(0)  # summed over the others
        divergence = (shares[0] * excess).sum(-1, keepdim=True)  # (B, 1)
        ctx.save_for_backward(shares, excess, divergence)
        loss: Tensor = divergence.mean()
        return loss

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: Tensor) -> Tensor:
        shares, excess, divergence = ctx.saved_tensors
        found: Tensor = shares - shares[:1]  # the gradient of the others
        torch.mul(shares[0], excess - divergence, out=found[0])
        return found.mul_(grad / len(divergence))
