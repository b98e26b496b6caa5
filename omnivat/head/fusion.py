"""Late fusion: combine the logits of the VIS and TAC branches into one prediction.

mean        mean of the two softmaxes
product     softmax of the mean of the two log-probabilities, a product of experts
confidence  mean of the softmaxes, weighted by certainty: log K minus the entropy
feature     one classification of the sum of the two features
"""

import math
from collections.abc import Callable, Mapping

import torch
from jaxtyping import Float
from torch import Tensor

from omnivat.kit.tables import entry

TINY = 1e-12


# by reading: log-probabilities are divided by it. It changes the confidence, never the predicted
# class. These hold until some are fitted on held-out source pairs
Temperatures = Mapping[str, float]
UNFITTED: Temperatures = {"fused": 1.0, "vis": 1.0, "tac": 1.0}


def tempered(logits: Float[Tensor, "*any K"], temperature: float) -> Float[Tensor, "*any K"]:
    """Return softmax(logits / T).

    >>> import torch
    >>> logits = torch.tensor([2.0, 0.0])
    >>> tempered(logits, 1.0), tempered(logits, 4.0)
    (tensor([0.8808, 0.1192]), tensor([0.6225, 0.3775]))
    """
    return torch.softmax(logits / temperature, dim=-1)


def fuse(
    kind: str,
    logits: Mapping[str, Float[Tensor, "B K"]],
    pair: Float[Tensor, "B K"] | None,
    temperature: float,
) -> Float[Tensor, "B K"]:
    """Return the pair's class probabilities, tempered.

    kind    of `FUSIONS`
    logits  of "vis" and "tac"
    pair    logits of the summed features, for "feature"

    With temperature 1, "mean" is the plain mean of the softmaxes.
    """
    if kind == "feature":
        assert pair is not None, "feature fusion needs the logits of the summed features"
        return tempered(pair, temperature)
    mixed = fused_logs(kind, logits["vis"], logits["tac"])
    return mixed.exp() if temperature == 1 else tempered(mixed, temperature)


def fused_logs(
    kind: str, vis: Float[Tensor, "*any K"], tac: Float[Tensor, "*any K"]
) -> Float[Tensor, "*any K"]:
    """Return log-probabilities of two sets of logits under a late fusion.

    Raises MissingNameError with the nearest name for an unknown fusion.
    """
    logs = torch.stack((torch.log_softmax(vis, dim=-1), torch.log_softmax(tac, dim=-1)))
    fused: Tensor = entry(LATE, kind, kind="late fusion")(logs)
    return fused


def _confidence(logs: Float[Tensor, "2 *any K"]) -> Float[Tensor, "*any K"]:
    # log K minus the entropy: 0 if uniform
    certainty = math.log(logs.shape[-1]) + (logs.exp() * logs).sum(-1, keepdim=True)
    weights = certainty.clamp_min(TINY)
    weights = weights / weights.sum(0)
    return torch.logsumexp(logs + weights.clamp_min(TINY).log(), dim=0)


# by name: of the log-probabilities of VIS and TAC
LATE: dict[str, Callable[[Float[Tensor, "2 *any K"]], Float[Tensor, "*any K"]]] = {
    "mean": lambda logs: torch.logsumexp(logs, dim=0) - math.log(2),
    "product": lambda logs: torch.log_softmax(logs.mean(0), dim=-1),
    "confidence": _confidence,
}
FUSIONS = (*LATE, "feature")
