"""From training pairs to a finished head in memory: plan, train, calibrate, evaluate."""

from omnivat.training.from_pairs.finish import head_from_pairs, trained_head
from omnivat.training.from_pairs.plan import TrainingPlan, plan_like, plan_training
from omnivat.training.from_pairs.report import EpochReport

__all__ = [
    "EpochReport",
    "TrainingPlan",
    "head_from_pairs",
    "plan_like",
    "plan_training",
    "trained_head",
]
