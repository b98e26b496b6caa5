"""Calibration of a head's confidence, from held-out source pairs.

fit.py          temperatures and the weight of a learned fusion, from held-out predictions
familiarity.py  distance of an image to the training images, relative to their own distances
"""

from omnivat.calibration.familiarity import Familiarity, familiarity_of
from omnivat.calibration.fit import fit_calibration, fit_share, fit_temperature

__all__ = ["Familiarity", "familiarity_of", "fit_calibration", "fit_share", "fit_temperature"]
