"""Stages of a head, modalities, and orders p."""

from typing import Any

from omnivat.kit.errors import SettingsError

IMAGES = ("vis", "tac")
MODALITIES = ("lang", *IMAGES)
# Raw embedding and raw DFrFT have the same distances and cosines at every order, because the
# transform is unitary.
STILL = ("raw", "frft")
STAGE_TITLES = {
    "raw": "raw embedding E",
    "frft": "raw DFrFT",
    "relu": "F after ReLU",
    "f_bar": "F after FrATT",
    "f_hat": "F after DTG",
}
STAGES = tuple(STAGE_TITLES)
STOPS = tuple(k / 100 for k in range(101))  # of p on the page
LIMIT = 4.0  # quarter turns; the transform repeats after 4


def checked_order(order: Any, *, name: str = "order") -> float:
    """Return the order as a float.

    order  quarter turns, from -4 to 4
    name   its name in the error
    Raises SettingsError for anything else; the message has the equivalent order in range, if any.
    """
    number = isinstance(order, int | float) and not isinstance(order, bool)
    if number and abs(order) <= LIMIT:
        return float(order)
    # not NaN, infinite, or without fraction
    exact = number and (isinstance(order, int) or abs(order) < 1e15)
    same = f" The transform has period 4, so use {order % 4:g}." if exact else ""
    raise SettingsError(
        f"{name} is {_shown(order)}; give a number of quarter turns from -4 to 4.{same}"
    )


def fitting(learned: float, width: int) -> tuple[float, float]:
    """Return the lowest and highest order p for which the weights of a head were trained.

    learned  the head's order, quarter turns
    width    D: the phases of the transform turn by D times the change of the order

    >>> fitting(0.5, 64)
    (0.46875, 0.53125)
    """
    return learned - 2 / width, learned + 2 / width


def _shown(order: Any) -> str:
    if isinstance(order, int) and not isinstance(order, bool) and abs(order) >= 10**40:
        return "a whole number of more than 40 digits"  # Python refuses to write very long ones
    return f"{order!r:.40}"


def optional_order(order: Any, *, name: str = "order") -> float | None:
    """Return the checked order, or None if none is given."""
    return None if order is None else checked_order(order, name=name)
