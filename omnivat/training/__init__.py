"""From pairs to a head: plan, settings, batches, steps, order search, resumable state, calibration.

Imports `head`, `encoders`, `data`, `fractional` and `kit`; `omnivat.measure.known.scored` measures
the head. A new loss or step belongs in `steps`; what a run may choose is a field of
`TrainSettings`.
"""

from omnivat.training.finish import trained_head
from omnivat.training.plan import TrainingPlan, plan_like, plan_training
from omnivat.training.settings import TrainSettings
from omnivat.training.state import STATE
from omnivat.training.training import Trained, train
from omnivat.training.watch import Watch

__all__ = [
    "STATE",
    "TrainSettings",
    "Trained",
    "TrainingPlan",
    "Watch",
    "plan_like",
    "plan_training",
    "train",
    "trained_head",
]
