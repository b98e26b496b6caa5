"""Evaluate a set of embeddings at many orders: features, predictions and gaps as functions of p."""

from omnivat.kit.stages import STAGES, STILL
from omnivat.maps.sweep.curves import MEASURES, Sweep, facts_of, measured, sweep
from omnivat.maps.sweep.walk import AtOrder, Features, coarse_first, walk

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
