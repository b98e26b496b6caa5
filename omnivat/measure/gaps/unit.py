"""What the measures share: unit rows, the size of a set, an estimate with its error."""

from dataclasses import dataclass

from jaxtyping import Float
from torch import Tensor

from omnivat.kit.shapes import unit as unit


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value and its standard error."""

    value: Float[Tensor, ""]
    error: Float[Tensor, ""]
