"""A value computed once, on first use, by any thread."""

from collections.abc import Callable
from threading import Lock
from typing import Generic, TypeVar

V = TypeVar("V")


class Lazy(Generic[V]):
    """Holds the result of `make`. After a failure, the next use tries again."""

    def __init__(self, make: Callable[[], V]) -> None:
        self._make = make
        self._lock = Lock()
        self._made: list[V] = []

    @property
    def ready(self) -> bool:
        """True if the value exists."""
        return bool(self._made)

    def __call__(self) -> V:
        if not self._made:
            with self._lock:
                if not self._made:
                    self._made.append(self._make())
        return self._made[0]
