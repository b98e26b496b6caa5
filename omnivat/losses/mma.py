"""Multimodal alignment (MMA) loss: VIS and TAC are drawn to LANG."""

from torch import Tensor
from torch.nn.functional import kl_div, log_softmax

from omnivat.shapes import require_shapes


def mma_loss(lang: Tensor, vis: Tensor | None = None, tac: Tensor | None = None) -> Tensor:
    """Multimodal alignment (MMA): KL(LANG || VIS) + KL(LANG || TAC), without the weight λ.

    lang, vis, tac  (B, D) features; a softmax over D makes each a distribution. A modality that is
                    not there (None) has no term
    return          () nats, >= 0, mean over the batch; 0 where they agree

    LANG is the reference, the first argument of the divergence. Gradients flow to all.
    Raises ShapeError if shapes differ.
    Source: paper, L_MMA.
    """
    others = {name: x for name, x in (("vis", vis), ("tac", tac)) if x is not None}
    require_shapes(lang=(lang, "B D"), **{name: (x, "B D") for name, x in others.items()})
    target = log_softmax(lang, dim=-1)
    total = lang.new_zeros(())
    for other in others.values():
        total = total + kl_div(
            log_softmax(other, dim=-1), target, reduction="batchmean", log_target=True
        )
    return total
