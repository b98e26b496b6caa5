"""From pairs to a head: settings, batches, steps, order search, resumable state, heads at stops of
p.

Imports `maps`, `measure`, `head`, `data` and `kit`. A new loss or step belongs in `steps`; what a
run may choose is a field of `TrainSettings`.
"""

from omnivat.training.settings import TrainSettings
from omnivat.training.state import STATE
from omnivat.training.training import Trained, train
from omnivat.training.watch import Watch

__all__ = ["STATE", "TrainSettings", "Trained", "Watch", "train"]
