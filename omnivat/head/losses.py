"""The losses: multimodal alignment (MMA), node diversity (NOD), and the joint loss with its
parts.
"""

from collections.abc import Sequence
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float, Int
from torch import Tensor
from torch.nn.functional import cross_entropy, mse_loss, normalize

from omnivat.head.output import TrainingOutput
from omnivat.kit.shapes import require_shapes


def mma_loss(
    lang: Float[Tensor, "B D"],
    vis: Float[Tensor, "B D"] | None = None,
    tac: Float[Tensor, "B D"] | None = None,
) -> Float[Tensor, ""]:
    """Return MMA, multimodal alignment: KL(LANG || VIS) + KL(LANG || TAC), without the weight λ.

    A softmax over D makes each feature a distribution; an absent modality has no term. In nats, >=
    0, mean over the batch; 0 if they agree. LANG is the reference, the first argument of the
    divergence. Gradients flow to all. Raises ShapeError if shapes differ. Source: paper, Eq. 7.
    """
    others = {name: x for name, x in (("vis", vis), ("tac", tac)) if x is not None}
    require_shapes(lang=(lang, "B D"), **{name: (x, "B D") for name, x in others.items()})
    logs = torch.log_softmax(torch.stack((lang, *others.values())), dim=-1)
    excess = logs[0] * len(others) - logs[1:].sum(0)  # (B, D), summed over the others
    return (logs[0].exp() * excess).sum(1).mean()


MMA_WEIGHT, NOD_WEIGHT = 10.0, 1.0  # λ, and that of NOD
EPS = 1e-12  # below this length a node has no direction


def nod_loss(layers: Sequence[Float[Tensor, "B _ D"]]) -> Float[Tensor, ""]:
    """Return NOD, node diversity: the distance of each level's cosine matrix from the identity.

    layers  the levels r = 1..R, of 2^(r-1) nodes each; at least one
    return  >= 0: Frobenius norms summed over levels, mean over the batch

    A level of one node is left out: its cosine with itself is 1, so its norm and gradient are 0.
    Negative and positive cosines count equally, as printed.
    Source: paper, Eq. 9 and 10.
    """
    total = layers[0].new_zeros(())
    for nodes in (level for level in layers if level.shape[1] > 1):
        units = normalize(nodes, dim=-1, eps=EPS)
        cosines = units @ units.mT
        apart = cosines - torch.diag_embed(cosines.diagonal(dim1=-2, dim2=-1))
        total = total + torch.linalg.matrix_norm(apart).mean()
    return total


class Losses(NamedTuple):
    """The parts of the joint loss, unweighted, and their weighted sum."""

    total: Float[Tensor, ""]
    mma: Float[Tensor, ""]
    nod: Float[Tensor, ""]
    cross_entropy: Float[Tensor, ""]


def joint_loss(
    output: TrainingOutput,
    labels: Int[Tensor, " B"],
    *,
    aligned: Bool[Tensor, " B"] | None = None,
    mma_weight: float = MMA_WEIGHT,
    nod_weight: float = NOD_WEIGHT,
    targets: dict[str, Float[Tensor, "B K"]] | None = None,
) -> Losses:
    """Return λ MMA + NOD + CE, the mean of the two logits'.

    aligned   pairs that MMA acts on; None: all
    targets   logits of another head, by the same names. The total then has their mean squared
              difference from `logits` in place of CE
    Source: paper, Eq. 12; for `targets`, docs/order.md.
    """
    features, logits = output.features, output.logits
    mma = nod = output.layers[0].new_zeros(())
    if "lang" in features and mma_weight:
        mma = mma_loss(**{n: x if aligned is None else x[aligned] for n, x in features.items()})
    if nod_weight:
        nod = nod_loss(output.layers)
    ce = fit = torch.stack([cross_entropy(values, labels) for values in logits.values()]).mean()
    if targets is not None:
        fit = torch.stack([mse_loss(logits[n], targets[n]) for n in logits]).mean()
    return Losses(mma_weight * mma + nod_weight * nod + fit, mma, nod, ce)
