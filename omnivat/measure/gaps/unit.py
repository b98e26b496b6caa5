"""What the measures share: unit rows, the size of a set, an estimate with its error."""

from dataclasses import dataclass

from jaxtyping import Float
from torch import Tensor

from omnivat.kit.errors import ShapeError
from omnivat.kit.shapes import unit as unit


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value and its standard error."""

    value: Float[Tensor, ""]
    error: Float[Tensor, ""]


def require_rows(least: int, **sets: Tensor) -> None:
    """Raise ShapeError for sets with fewer than `least` rows; the message names them."""
    for name, rows in sets.items():
        if len(rows) < least:
            raise ShapeError(
                f"{name} has {len(rows)} rows; this measure needs {least} or more. Choose a larger"
                " set."
            )
