"""Fit temperatures and the weight of a learned fusion to held-out source pairs."""

from collections.abc import Callable, Mapping

import torch
from torch import Tensor
from torch.nn.functional import nll_loss

from omnivat.errors import DataError
from omnivat.model.fusion import Calibration, fused_logs

LOWEST, HIGHEST = 0.05, 20.0  # temperatures
STEPS = 32  # of the golden section; relative error 1e-6
SHARES = 21  # evenly from 0 to 1
GOLDEN = (5**0.5 - 1) / 2


def fit_temperature(logits: Tensor, labels: Tensor) -> float:
    """Return the temperature in [0.05, 20] with the lowest mean negative log-likelihood.

    logits  (N, K) logits or log-probabilities;  labels  (N,)

    The loss is convex in 1/T, so the golden section in log T finds its minimum.
    Raises DataError without pairs.
    Source: Guo et al., ICML 2017.
    """
    if not len(labels):
        raise DataError("A temperature needs held-out pairs; there are none.")
    values = logits.double()

    def loss(log_temperature: float) -> float:
        return _nll(values / _exp(log_temperature), labels)

    ends = torch.tensor([LOWEST, HIGHEST], dtype=torch.float64).log().tolist()
    return _exp(_lowest(loss, ends[0], ends[1]))


def fit_share(vis: Tensor, tac: Tensor, labels: Tensor) -> float:
    """Return the weight of VIS, 0 to 1, with the best weighted log-probabilities.

    vis, tac  (N, K) logits;  labels  (N,)

    Every share is scored at its own best temperature, so that confidence does not affect the
    choice. Ties go to the share nearest to 0.5.
    """

    def loss(share: float) -> tuple[float, float]:
        mixed = fused_logs("learned", vis.double(), tac.double(), share)
        return round(_nll(mixed / fit_temperature(mixed, labels), labels), 9), abs(share - 0.5)

    shares: list[float] = torch.linspace(0, 1, SHARES, dtype=torch.float64).tolist()
    return min(shares, key=loss)


def fit_calibration(logits: Mapping[str, Tensor], labels: Tensor, *, fusion: str = "mean") -> Calibration:
    """Return temperatures for "fused", "vis" and "tac", and the share of a learned fusion.

    logits  of held-out pairs: "vis" and "tac" with the other image absent; "vis_branch" and
            "tac_branch" inside the pair, "pair" of the summed features. A missing one keeps
                    temperature 1
            fusion  late fusion of the branches
    """
    temperature = {name: fit_temperature(logits[name], labels) if name in logits else 1.0 for name in ("vis", "tac")}
    share = 0.5
    if "vis_branch" in logits and "tac_branch" in logits:
        branches = logits["vis_branch"], logits["tac_branch"]
        share = fit_share(*branches, labels)
        fused = logits["pair"] if fusion == "feature" else fused_logs(fusion, *branches, share)
        temperature["fused"] = fit_temperature(fused, labels)
    elif "fused" in logits:
        temperature["fused"] = fit_temperature(logits["fused"], labels)
    else:
        temperature["fused"] = next(temperature[n] for n in ("vis", "tac") if n in logits)
    return Calibration(temperature=temperature, share=share)


def _nll(logits: Tensor, labels: Tensor) -> float:
    return float(nll_loss(torch.log_softmax(logits, dim=-1), labels))


def _exp(value: float) -> float:
    return float(torch.tensor(value, dtype=torch.float64).exp())


def _lowest(loss: Callable[[float], float], low: float, high: float) -> float:
    """Return the minimum of a unimodal function, by golden section."""
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = loss(left), loss(right)
    for _ in range(STEPS):
        if at_left <= at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = loss(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = loss(right)
    return (low + high) / 2
