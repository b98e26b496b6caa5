"""A value made with its first use, once, whichever thread asks first."""

from collections.abc import Callable
from threading import Lock
from typing import Generic, TypeVar

V = TypeVar("V")


class Once(Generic[V]):
    """Holds what `make` returns. A failure is not kept: the next use tries again."""

    def __init__(self, make: Callable[[], V]) -> None:
        self._make = make
        self._lock = Lock()
        self._made: list[V] = []

    @property
    def ready(self) -> bool:
        """Whether the value is there already."""
        return bool(self._made)

    def __call__(self) -> V:
        if not self._made:
            with self._lock:
                if not self._made:
                    self._made.append(self._make())
        return self._made[0]
