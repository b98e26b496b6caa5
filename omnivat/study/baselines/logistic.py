"""Logistic regression on a view of the source, its penalty chosen on held-out objects."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from torch import Tensor
from torch.nn.functional import linear

from omnivat.kit.logistic import scaling, solve
from omnivat.study.baselines.contract import Fitted, Rows, Source
from omnivat.study.baselines.evidence import best

STRENGTHS = {f"{c:g}": c for c in (1.0, *(10.0**power for power in range(-5, 5)))}  # C
View = Callable[[Tensor, Tensor], Tensor]  # VIS and TAC (B, D) -> rows (B, W)


def fit_logistic(source: Source, view: View) -> Fitted:
    """Fit one view of the source; held-out objects choose C, the inverse of the penalty, which is 1
    without any.
    """
    fit = partial(_fitted, view=view)
    strength = STRENGTHS[best(source, STRENGTHS, fit)]
    return replace(fit(source, strength), chosen={"C": strength})


def _fitted(source: Source, strength: float, view: View) -> Fitted:
    full = source.both_views()
    rows = view(full.vis, full.tac).double()
    scale = scaling(rows)
    weight, bias = solve(scale(rows), full.labels, len(source.classes), strength)

    def predict(vis: Tensor, tac: Tensor) -> Rows:
        some = view(vis, tac)
        return {"fused": linear(scale(some.double()), weight, bias).softmax(-1).to(some.dtype)}

    return Fitted(predict=predict, parameters=weight.numel() + bias.numel())
