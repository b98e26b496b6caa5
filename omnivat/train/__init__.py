"""Training: settings, batches, steps, the search for an order, and a state that can be resumed."""

from omnivat.train.loop import Trained
from omnivat.train.settings import MODALITIES, SELECTIONS, TrainSettings
from omnivat.train.state import STATE
from omnivat.train.training import SEARCH, train
from omnivat.train.watch import TrainingCancelled, Watch

__all__ = [
    "MODALITIES",
    "SEARCH",
    "SELECTIONS",
    "STATE",
    "TrainSettings",
    "Trained",
    "TrainingCancelled",
    "Watch",
    "train",
]
