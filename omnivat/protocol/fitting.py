"""Fit one method on one source: choose its settings, fit its temperatures, train it on all pairs.

Choices and temperatures use held-out objects of the source, a quarter of each class. For one seed,
the head and the baselines hold out the same objects (`omnivat.baselines.evidence.folds`).
"""

from omnivat.lang.bank import LangBank
from omnivat.protocol.choosing import Choice, Outcome
from omnivat.protocol.fitting_baseline import fit_baseline
from omnivat.protocol.fitting_head import fit_head
from omnivat.protocol.methods import HEAD, Method
from omnivat.protocol.settings import Task


def fit(
    method: Method,
    found: Task,
    bank: LangBank | None,
    *,
    seed: int,
    calibrate: bool,
    prior: Choice | None = None,
) -> Outcome:
    """Fit a method on the task's training pairs.

    calibrate  also choose the fusion and fit temperatures, with one more training for each candidate
               on three quarters of the objects
    prior      choices of another seed on this source; they are not made again
    Raises a child of OmniVatError if the method cannot run on these pairs.
    """
    fitted = fit_head if method.base == HEAD else fit_baseline
    return fitted(method, found, bank, seed, calibrate, prior)
