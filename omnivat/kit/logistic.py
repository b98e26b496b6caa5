"""Multinomial logistic regression with an L2 penalty, solved to convergence by L-BFGS."""

from collections.abc import Callable
from dataclasses import dataclass

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
    small
                sources favour it, but axes that hardly vary in the source become huge on another
                sensor
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

    The optimum lies in the span of the rows. For N < D it is computed there: exact and faster.
    """
    problem = Problem.of(rows, labels, classes)
    return problem.parameters(problem.solved(strength, problem.start()))


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """Rows in a basis of their span, computed once for several penalties."""

    inside: NDArray[np.float64]  # (N, R)
    labels: NDArray[np.int64]  # (N,)
    classes: int
    basis: Tensor | None  # (D, R); None where R = D

    @classmethod
    def of(cls, rows: Tensor, labels: Tensor, classes: int) -> "Problem":
        """Prepare rows (N, D) of float64 and labels (N,)."""
        count, width = rows.shape
        basis = torch.linalg.qr(rows.T).Q if count < width else None
        inside = rows if basis is None else rows @ basis
        return cls(inside=inside.numpy(), labels=labels.numpy(), classes=classes, basis=basis)

    def start(self) -> NDArray[np.float64]:
        """Return zero parameters (K, R + 1), flat."""
        return np.zeros(self.classes * (self.inside.shape[1] + 1))

    def solved(self, strength: float, start: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the parameters that minimise the objective, starting from given ones."""
        from scipy.optimize import minimize

        found = minimize(
            self._objective,
            start,
            args=(strength,),
            jac=True,
            method="L-BFGS-B",
            options={"maxiter": 500, "maxcor": 20, "gtol": 1e-8, "ftol": 1e-8**2 * 10},
        )
        parameters: NDArray[np.float64] = found.x
        return parameters

    def _objective(
        self, flat: NDArray[np.float64], strength: float
    ) -> tuple[float, NDArray[np.float64]]:
        """Return the objective and its gradient at flat parameters."""
        checkpoint()
        count, both = len(self.labels), flat.reshape(self.classes, -1)
        weight, bias = both[:, :-1], both[:, -1]
        logits = self.inside @ weight.T + bias
        logits -= logits.max(1, keepdims=True)
        shares = np.exp(logits)
        totals = shares.sum(1, keepdims=True)
        own = np.arange(count), self.labels
        loss = float((np.log(totals[:, 0]) - logits[own]).mean())
        shares /= totals
        shares[own] -= 1
        shares /= count
        gradient = np.empty_like(both)
        gradient[:, :-1] = shares.T @ self.inside + weight / (strength * count)
        gradient[:, -1] = shares.sum(0)
        return loss + float((weight**2).sum()) / (2 * strength * count), gradient.ravel()

    def parameters(self, flat: NDArray[np.float64]) -> tuple[Tensor, Tensor]:
        """Return W (K, D) and b (K,) of flat parameters."""
        both = torch.from_numpy(flat.reshape(self.classes, -1).copy())
        weight = both[:, :-1] if self.basis is None else both[:, :-1] @ self.basis.T
        return weight, both[:, -1]
