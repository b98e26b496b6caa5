"""Multinomial logistic regression with an L2 penalty, solved to convergence by L-BFGS."""

from collections.abc import Callable

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import normalize

from omnivat.kit.progress import checkpoint


def scaling(rows: Tensor, kind: str = "unit") -> Callable[[Tensor], Tensor]:
    """Return the scaling that rows (N, D) need, a function of any rows.

    "unit"      unit length, centred, one scale for all axes (mean squared length D)
    "standard"  mean 0 and variance 1 on each axis; a constant axis becomes 0. Probes do not use it:
                small sources favour it, but axes that hardly vary in the source become huge on
                another sensor
    """
    unit = kind == "unit"
    rows = normalize(rows, dim=-1) if unit else rows
    mean = rows.mean(0)
    spread = (rows - mean).square().mean() if unit else (rows - mean).square().mean(0)
    floor = torch.finfo(rows.dtype).eps ** 2 * rows.square().mean()  # constant up to rounding
    scale = torch.where(spread > floor, spread.rsqrt(), torch.zeros_like(spread))
    return lambda some: ((normalize(some, dim=-1) if unit else some) - mean) * scale


def solve(rows: Tensor, labels: Tensor, classes: int, strength: float) -> tuple[Tensor, Tensor]:
    """Minimise mean cross-entropy + |W|² / (2 C N): rows (N, D), labels (N,) -> W (K, D), b (K,).

    rows  float64. For N < D, the optimum is computed in their span, where it lies: exact and faster
    """
    from scipy.optimize import minimize
    from scipy.special import log_softmax

    count, width = rows.shape
    basis = torch.linalg.qr(rows.T).Q if count < width else None
    inside = (rows if basis is None else rows @ basis).numpy()
    truth = np.eye(classes)[labels.numpy()]

    def objective(flat: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        """Return the value and the gradient."""
        checkpoint()
        both = flat.reshape(classes, -1)
        weight, penalty = both[:, :-1], 1 / (strength * count)
        logs = log_softmax(inside @ weight.T + both[:, -1], axis=1)
        errors = (np.exp(logs) - truth) / count
        gradient = np.column_stack([errors.T @ inside + penalty * weight, errors.sum(0)])
        loss = penalty * (weight**2).sum() / 2 - (truth * logs).sum() / count
        return loss, gradient.ravel()

    start = np.zeros(classes * (inside.shape[1] + 1))
    how = {"maxiter": 500, "maxcor": 20, "gtol": 1e-8, "ftol": 1e-8**2 * 10}
    found = minimize(objective, start, jac=True, method="L-BFGS-B", options=how).x
    weight, bias = torch.from_numpy(found).view(classes, -1).split(inside.shape[1], 1)
    return weight if basis is None else weight @ basis.T, bias[:, 0]
