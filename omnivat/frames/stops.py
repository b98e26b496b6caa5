"""Stops of the slider: round ones, and one at exactly the learned order."""

from collections.abc import Sequence

CLOSE = 0.0005  # quarter turns: a round stop this close to the learned order is replaced by it


def with_learned(orders: Sequence[float], learned: float | None) -> tuple[float, ...]:
    """Return the orders with a stop at exactly `learned`, ascending.

    A learned order outside the range of `orders` is not added, so the slider keeps its ends.

    >>> with_learned((0.0, 0.5, 1.0), 0.4983)
    (0.0, 0.4983, 0.5, 1.0)
    >>> with_learned((0.0, 0.5, 1.0), 0.5002)
    (0.0, 0.5002, 1.0)
    """
    given = sorted(float(order) for order in orders)
    if learned is None or not given or not given[0] <= learned <= given[-1]:
        return tuple(given)
    kept = [order for order in given if abs(order - learned) >= CLOSE]
    return tuple(sorted([*kept, float(learned)]))
