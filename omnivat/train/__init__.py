"""Training: settings, batches, steps, a state that can be taken up again, and the loop."""

from omnivat.train.loop import Trained, train
from omnivat.train.settings import MODALITIES, SELECTIONS, TrainSettings
from omnivat.train.state import STATE

__all__ = ["MODALITIES", "SELECTIONS", "STATE", "TrainSettings", "Trained", "train"]
