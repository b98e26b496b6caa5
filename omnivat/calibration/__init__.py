"""What a head learns about its own confidence, from source pairs that it was not trained on.

fit.py          temperatures and the weight of a learned fusion, from held-out predictions
familiarity.py  how near an image lies to the training images, against the set's own distances
"""

from omnivat.calibration.familiarity import Familiarity, familiarity_of
from omnivat.calibration.fit import fit_calibration, fit_share, fit_temperature

__all__ = ["Familiarity", "familiarity_of", "fit_calibration", "fit_share", "fit_temperature"]
