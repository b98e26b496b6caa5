"""Multinomial logistic regression with an L2 penalty, solved to the end by L-BFGS."""

from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import cross_entropy, linear, normalize

from omnivat.baselines.contract import Source
from omnivat.baselines.evidence import Score, folds

STRENGTHS = tuple(10.0**power for power in range(-5, 5))  # C: the inverse of the penalty
# Z-scores of every axis are not offered: on small sources held-out objects like them, and axes that
# hardly move in the source blow up on another sensor (docs/log.md).
SCALINGS = ("unit",)
View = Callable[[Source], Tensor]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scaling:
    """Rows to unit length or not, then shift and scale that the source gave."""

    unit: bool
    mean: Tensor
    scale: Tensor

    def __call__(self, rows: Tensor) -> Tensor:
        rows = normalize(rows, dim=-1) if self.unit else rows
        return (rows - self.mean) * self.scale


def scaling(rows: Tensor, kind: str) -> Scaling:
    """Return the scaling that rows (N, D) ask for.

    "unit"      unit length, centred, one scale for all axes (mean squared length D)
    "standard"  mean 0 and variance 1 on each axis; an axis that never moves is left at 0
    """
    unit = kind == "unit"
    rows = normalize(rows, dim=-1) if unit else rows
    mean = rows.mean(0)
    spread = (rows - mean).square().mean() if unit else (rows - mean).square().mean(0)
    floor = torch.finfo(rows.dtype).eps ** 2 * rows.square().mean()  # constant up to rounding
    scale = torch.where(spread > floor, spread.clamp_min(1e-30).rsqrt(), torch.zeros_like(spread))
    return Scaling(unit=unit, mean=mean, scale=scale)


@dataclass(frozen=True, slots=True, kw_only=True)
class Logistic:
    """A fitted regression: scaling, weight (K, D) and bias (K,), all float64."""

    scaling: Scaling
    weight: Tensor
    bias: Tensor
    strength: float
    kind: str

    def probabilities(self, rows: Tensor) -> Tensor:
        """Return class probabilities (B, K) of rows (B, D), in their precision."""
        scaled = self.scaling(rows.double())
        return linear(scaled, self.weight, self.bias).softmax(-1).to(rows.dtype)

    @property
    def parameters(self) -> int:
        return self.weight.numel() + self.bias.numel()


def solve(
    rows: Tensor, labels: Tensor, classes: int, strength: float, *, start: Tensor | None = None
) -> tuple[Tensor, Tensor]:
    """Minimise mean cross-entropy + |W|² / (2 C N): rows (N, D), labels (N,) -> W (K, D), b (K,).

    The optimum lies in the span of the rows, so with N < D it is sought there: exact and faster.
    start    parameters of a neighbouring problem, as this function keeps them, or None
    """
    weight, bias, _ = _solve(rows, labels, classes, strength, start)
    return weight, bias


def _solve(
    rows: Tensor, labels: Tensor, classes: int, strength: float, start: Tensor | None
) -> tuple[Tensor, Tensor, Tensor]:
    count, width = rows.shape
    basis = torch.linalg.qr(rows.T).Q if count < width else None  # (D, N)
    inside = rows if basis is None else rows @ basis
    flat = torch.zeros(classes, inside.shape[1] + 1, dtype=rows.dtype) if start is None else start
    flat = flat.clone().requires_grad_(True)
    solver = torch.optim.LBFGS(
        [flat],
        max_iter=100,
        tolerance_grad=1e-6,
        tolerance_change=1e-10,
        history_size=20,
        line_search_fn="strong_wolfe",
    )

    def objective() -> Tensor:
        solver.zero_grad()
        loss = cross_entropy(linear(inside, flat[:, :-1], flat[:, -1]), labels)
        loss = loss + flat[:, :-1].square().sum() / (2 * strength * count)
        loss.backward()
        return loss

    solver.step(objective)
    found = flat.detach()
    weight = found[:, :-1] if basis is None else found[:, :-1] @ basis.T
    return weight, found[:, -1], found


def fit_logistic(source: Source, view: View) -> Logistic:
    """Fit on one view of the source, C and scaling chosen by held-out objects.

    view  Source -> rows (N, D): VIS, TAC or both side by side
    """
    kind, strength = _choose(source, view)
    full = source.both_views()
    rows = view(full).double()
    scale = scaling(rows, kind)
    weight, bias = solve(scale(rows), full.labels, len(source.classes), strength)
    return Logistic(scaling=scale, weight=weight, bias=bias, strength=strength, kind=kind)


def _choose(source: Source, view: View) -> tuple[str, float]:
    """Return the scaling and C that held-out objects prefer; unit and 1 without evidence."""
    scores: dict[tuple[str, float], Score] = {}
    for fitted, held in folds(source):
        part, rest = source.select(fitted).both_views(), source.select(held)
        raw, test = view(part).double(), view(rest).double()
        for kind in SCALINGS:
            scale = scaling(raw, kind)
            rows, start = scale(raw), None
            for strength in STRENGTHS:  # each starts where its neighbour ended
                weight, bias, start = _solve(
                    rows, part.labels, len(source.classes), strength, start
                )
                answer = linear(scale(test), weight, bias).softmax(-1)
                scores.setdefault((kind, strength), Score()).add(answer, rest.labels)
    return max(scores, key=lambda choice: scores[choice].rank) if scores else ("unit", 1.0)
