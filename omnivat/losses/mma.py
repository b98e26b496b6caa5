"""Multimodal alignment (MMA) loss: VIS and TAC are drawn to LANG."""

from torch import Tensor
from torch.nn.functional import kl_div, log_softmax

from omnivat.shapes import require_shapes


def mma_loss(lang: Tensor, vis: Tensor, tac: Tensor) -> Tensor:
    """Multimodal alignment (MMA): KL(LANG || VIS) + KL(LANG || TAC), without the weight λ.

    lang, vis, tac  (B, D) features; a softmax over D makes each a distribution
    return          () nats, >= 0, mean over the batch; 0 where the three agree

    LANG is the reference, the first argument of the divergence. Gradients flow to all three.
    Raises ShapeError if shapes differ.
    Source: paper, L_MMA.
    """
    require_shapes(lang=(lang, "B D"), vis=(vis, "B D"), tac=(tac, "B D"))
    target = log_softmax(lang, dim=-1)
    return sum(  # type: ignore[return-value]  # a sum of tensors, never the int 0
        kl_div(log_softmax(other, dim=-1), target, reduction="batchmean", log_target=True)
        for other in (vis, tac)
    )
