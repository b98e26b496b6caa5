"""Evaluate a set of embeddings at many orders: features, predictions and gaps as functions of p."""

from omnivat.kit.stages import STAGES, STILL
from omnivat.maps.sweep.curves import MEASURES, Sweep, curve_values, facts_of, sweep
from omnivat.maps.sweep.walk import AtOrder, Features, walk

__all__ = [
    "MEASURES",
    "STAGES",
    "STILL",
    "AtOrder",
    "Features",
    "Sweep",
    "curve_values",
    "facts_of",
    "sweep",
    "walk",
]
