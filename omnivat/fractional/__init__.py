"""The discrete fractional Fourier transform: exact, fast, differentiable in x and in the order.

`dfrft(x, order)` transforms; `coefficients(x)` is what to keep while the order moves and
`synthesise(coefficients, order)` turns it into the same as `dfrft(x, order)` at a fraction of the
cost; `project` fuses a linear map with that. The mathematics: docs/fractional.md.
"""

from omnivat.fractional.basis import Basis, basis
from omnivat.fractional.coefficients import Coefficients
from omnivat.fractional.layer import FractionalTransform
from omnivat.fractional.transform import coefficients, dfrft, project, synthesise

__all__ = [
    "Basis",
    "Coefficients",
    "FractionalTransform",
    "basis",
    "coefficients",
    "dfrft",
    "project",
    "synthesise",
]
