"""Training: settings, batches, steps, order search, and resumable state."""

from omnivat.training.loop import Trained, TrainingCancelled, Watch
from omnivat.training.settings import TrainSettings
from omnivat.training.state import STATE
from omnivat.training.training import train

__all__ = ["STATE", "TrainSettings", "Trained", "TrainingCancelled", "Watch", "train"]
