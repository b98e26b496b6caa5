"""Calibration of confidence: calibration error, log-likelihood, risk against coverage."""

import torch
from jaxtyping import Float, Int
from torch import Tensor

from omnivat.kit.shapes import require_shapes

BINS = 15  # equal steps of confidence from 0 to 1; a border belongs to the lower bin


def ece(probabilities: Float[Tensor, "N K"], labels: Int[Tensor, " N"]) -> Float[Tensor, ""]:
    """Return the expected calibration error: mean over pairs of |accuracy - confidence| in the
    pair's bin.

    probabilities  rows that add up to 1; confidence is a row's largest entry
    return         in [0, 1]; NaN for no pairs

    Source: Guo et al., ICML 2017.

    >>> import torch
    >>> sure = torch.tensor([[0.9, 0.1]] * 10)
    >>> round(float(ece(sure, torch.zeros(10, dtype=torch.long))), 2)  # always right, at 90 %
    0.1
    """
    require_shapes(probabilities=(probabilities, "N K"), labels=(labels, "N"))
    if not len(labels):
        return probabilities.new_tensor(float("nan"))
    confidence, predicted = probabilities.max(1)
    place = ((confidence * BINS).ceil().long() - 1).clamp(0, BINS - 1)
    surplus = (predicted == labels).to(confidence.dtype) - confidence
    by_bin = confidence.new_zeros(BINS).index_add_(0, place, surplus)
    return by_bin.abs().sum() / len(labels)


def nll(probabilities: Float[Tensor, "N K"], labels: Int[Tensor, " N"]) -> Float[Tensor, ""]:
    """Return the mean negative log probability of the true class, in nats; NaN for no pairs.

    >>> import torch
    >>> nll(torch.tensor([[0.5, 0.5]]), torch.tensor([0]))
    tensor(0.6931)
    """
    require_shapes(probabilities=(probabilities, "N K"), labels=(labels, "N"))
    own = probabilities.gather(1, labels[:, None])[:, 0]
    return -own.clamp_min(1e-12).log().mean()


def aurc(probabilities: Float[Tensor, "N K"], labels: Int[Tensor, " N"]) -> Float[Tensor, ""]:
    """Return the area under the risk-coverage curve, in [0, 1]; NaN for no pairs.

    The mean over n = 1 .. N of the error rate of the n most confident pairs. Confidence is a row's
    largest entry; pairs with equal confidence keep their order. Source: Geifman and El-Yaniv,
    NeurIPS 2017.

    >>> import torch
    >>> shares = torch.tensor([[0.9, 0.1], [0.6, 0.4]])  # the second one is wrong, and less sure
    >>> aurc(shares, torch.tensor([0, 1])), aurc(shares, torch.tensor([1, 0]))
    (tensor(0.2500), tensor(0.7500))
    """
    require_shapes(probabilities=(probabilities, "N K"), labels=(labels, "N"))
    confidence, predicted = probabilities.max(1)
    order = confidence.argsort(descending=True, stable=True)
    wrong = (predicted != labels)[order].to(confidence.dtype)
    risks: Tensor = wrong.cumsum(0) / torch.arange(1, len(labels) + 1, dtype=confidence.dtype)
    return risks.mean()
