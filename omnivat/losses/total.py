"""The joint loss of the head, and its parts for the log."""

from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn.functional import cross_entropy, mse_loss

from omnivat.losses.mma import mma_loss
from omnivat.losses.nod import nod_loss
from omnivat.modalities import MODALITIES


class Losses(NamedTuple):
    """The parts of the joint loss, unweighted, and their weighted sum."""

    total: Tensor
    mma: Tensor
    nod: Tensor
    cross_entropy: Tensor


def joint_loss(
    *,
    features: dict[str, Tensor],
    layers: list[Tensor],
    logits: dict[str, Tensor],
    labels: Tensor,
    aligned: Tensor | None = None,
    mma_weight: float = 10.0,
    nod_weight: float = 1.0,
    targets: dict[str, Tensor] | None = None,
) -> Losses:
    """Return λ MMA + NOD + CE.

    features  F-bar (B, D) of "vis", "tac" or both, and of "lang" if present
    layers    the tree's levels (B, n, D)
    logits    (B, K) of "vis", "tac" or both; CE is their mean
    labels    (B,)
    aligned   (B,) bool: pairs that MMA acts on; None: all
    targets   (B, K) of the same names: logits of another head. The total then has their mean
              squared difference from `logits` in place of CE
    Source: paper, Eq. 12; for `targets`, docs/order.md.
    """
    zero = layers[0].new_zeros(())
    mma = zero
    if "lang" in features and mma_weight > 0:
        given = {n: features[n] for n in MODALITIES if n in features}
        mma = mma_loss(**{n: x if aligned is None else x[aligned] for n, x in given.items()})
    nod = nod_loss(layers) if nod_weight > 0 else zero
    ce = torch.stack([cross_entropy(values, labels) for values in logits.values()]).mean()
    fit = (
        ce
        if targets is None
        else torch.stack([mse_loss(logits[n], targets[n]) for n in logits]).mean()
    )
    return Losses(mma_weight * mma + nod_weight * nod + fit, mma, nod, ce)
