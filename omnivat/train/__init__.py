"""Training: settings, batches, steps, order search, and resumable state."""

from omnivat.train.loop import Trained, TrainingCancelled, Watch
from omnivat.train.settings import TrainSettings
from omnivat.train.state import STATE
from omnivat.train.training import train

__all__ = ["STATE", "TrainSettings", "Trained", "TrainingCancelled", "Watch", "train"]
