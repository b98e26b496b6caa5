"""From training pairs to a finished head in memory: plan, train, calibrate, evaluate."""

from omnivat.training.from_pairs.finish import trained_head
from omnivat.training.from_pairs.plan import TrainingPlan, plan_like, plan_training
from omnivat.training.from_pairs.report import EpochReport, reporter

__all__ = ["EpochReport", "TrainingPlan", "plan_like", "plan_training", "reporter", "trained_head"]
