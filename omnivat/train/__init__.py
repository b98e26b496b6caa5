"""Training: settings, batches, steps, order search, and resumable state."""

from omnivat.train.loop import Trained
from omnivat.train.settings import TrainSettings
from omnivat.train.state import STATE
from omnivat.train.training import SEARCH, train
from omnivat.train.watch import TrainingCancelled, Watch

__all__ = [
    "SEARCH",
    "STATE",
    "TrainSettings",
    "Trained",
    "TrainingCancelled",
    "Watch",
    "train",
]
