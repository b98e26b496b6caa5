"""The discrete fractional Fourier transform: exact, fast, differentiable in x and in the order.

`dfrft(x, order)` is the transform. To change the order of the same x, keep `coefficients(x)`:
`synthesise(coefficients, order)` equals `dfrft(x, order)` at a fraction of the cost. The
mathematics: docs/fractional.md. Imports `kit` alone, and every other wing may import it.
"""

from omnivat.fractional.coefficients import Coefficients
from omnivat.fractional.transform import (
    Basis,
    FractionalTransform,
    basis,
    coefficients,
    dfrft,
    synthesise,
)

__all__ = [
    "Basis",
    "Coefficients",
    "FractionalTransform",
    "basis",
    "coefficients",
    "dfrft",
    "synthesise",
]
