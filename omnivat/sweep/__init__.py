"""Evaluate a set of embeddings at many orders: features, predictions and gaps as functions of p."""

from omnivat.stages import STAGES, STILL
from omnivat.sweep.curves import MEASURES, Sweep, facts_of, measured, sweep
from omnivat.sweep.walk import AtOrder, Features, coarse_first, walk

__all__ = [
    "MEASURES",
    "STAGES",
    "STILL",
    "AtOrder",
    "Features",
    "Sweep",
    "coarse_first",
    "facts_of",
    "measured",
    "sweep",
    "walk",
]
