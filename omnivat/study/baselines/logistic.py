"""Logistic regression on a view of the source, its penalty chosen on held-out objects."""

from collections.abc import Callable
from dataclasses import dataclass

from torch import Tensor
from torch.nn.functional import linear

from omnivat.kit.logistic import Problem, scaling, solve
from omnivat.study.baselines.contract import Source
from omnivat.study.baselines.evidence import Score, folds

STRENGTHS = tuple(10.0**power for power in range(-5, 5))  # C: the inverse of the penalty
View = Callable[[Source], Tensor]


@dataclass(frozen=True, slots=True, kw_only=True)
class Logistic:
    """A fitted regression: scaling, weight (K, D) and bias (K,), all float64."""

    scaling: Callable[[Tensor], Tensor]
    weight: Tensor
    bias: Tensor
    strength: float

    def probabilities(self, rows: Tensor) -> Tensor:
        """Return class probabilities (B, K) of rows (B, D), in their precision."""
        scaled = self.scaling(rows.double())
        return linear(scaled, self.weight, self.bias).softmax(-1).to(rows.dtype)

    @property
    def parameters(self) -> int:
        return self.weight.numel() + self.bias.numel()


def fit_logistic(source: Source, view: View) -> Logistic:
    """Fit one view of the source; held-out objects choose C, which is 1 without any.

    view  Source -> rows (N, D): VIS, TAC or both concatenated
    """
    scores: dict[float, Score] = {}
    for fitted, held in folds(source):
        part, rest = source.select(fitted).both_views(), source.select(held)
        rows, test = view(part).double(), view(rest).double()
        scale = scaling(rows)
        problem = Problem.of(scale(rows), part.labels, len(source.classes))
        found = problem.start()
        for strength in STRENGTHS:  # each starts at the previous solution
            found = problem.solved(strength, found)
            predicted = linear(scale(test), *problem.parameters(found)).softmax(-1)
            scores.setdefault(strength, Score()).add(predicted, rest.labels)
    best = max(scores, key=lambda strength: scores[strength].rank) if scores else 1.0
    full = source.both_views()
    rows = view(full).double()
    scale = scaling(rows)
    weight, bias = solve(scale(rows), full.labels, len(source.classes), best)
    return Logistic(scaling=scale, weight=weight, bias=bias, strength=best)
