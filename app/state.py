"""References in requests: a pair of the set, an example, or an uploaded image.

Of uploaded images, the server keeps only embeddings, named by a hash of their content. A visitor
finds only what came from its own address.
"""

from collections import Counter, OrderedDict
from contextvars import ContextVar
from dataclasses import dataclass
from hashlib import blake2b
from threading import Lock
from typing import Any, Generic, TypeVar

from omnivat.errors import DataError
from omnivat.stages import optional_order


class ForgottenError(DataError):
    """The server no longer has an uploaded image; the page sends it again."""

    status = 410


KINDS = ("row", "example", "image")
LONGEST_NAME = 200
V = TypeVar("V")
# address of the visitor whose job runs here; "" for the server's own work
VISITOR: ContextVar[str] = ContextVar("visitor", default="")


@dataclass(frozen=True, slots=True)
class Ref:
    """One image by name: `row:12` of the set, `example:TAG-sim/wood/a`, `image:<content>`."""

    kind: str
    name: str

    def __str__(self) -> str:
        return f"{self.kind}:{self.name}"


def ref_from(value: Any) -> Ref | None:
    """Return the image reference in a request; None if it is left out.

    Raises DataError for anything else.
    """
    if value is None or value == "":
        return None
    if not isinstance(value, str) or len(value) > LONGEST_NAME:
        raise DataError("An image is named by a short text such as 'row:12'; choose one again.")
    kind, colon, name = value.partition(":")
    if kind not in KINDS or not colon or not name:
        raise DataError(
            f"'{value}' names no image; expected one of " + ", ".join(f"'{kind}:…'" for kind in KINDS) + "."
        )
    return Ref(kind, name)


def order_from(value: Any) -> float | None:
    """Return an order between -4 and 4 quarter turns, or None if none is given.

    Raises SettingsError for anything else.
    """
    return optional_order(value, name="p")


def content_name(content: bytes) -> str:
    """Return a hash of bytes, used as a name."""
    return blake2b(content, digest_size=16).hexdigest()


class Recent(Generic[V]):
    """The most recently used values, at most `limit` of them; safe between threads.

    own  a visitor finds only its own values, and beyond the limit, the visitor with most loses one
    """

    def __init__(self, limit: int, *, own: bool = False) -> None:
        self._limit, self._own = limit, own
        self._values: OrderedDict[tuple[str, str], V] = OrderedDict()
        self._lock = Lock()

    def get(self, name: str) -> V | None:
        """Return the value called `name`, or None if it is not kept."""
        key = self._key(name)
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
            return self._values.get(key)

    def keep(self, name: str, value: V) -> V:
        """Keep `value`; drop the least recently used one beyond the limit."""
        key = self._key(name)
        with self._lock:
            self._values[key] = value
            self._values.move_to_end(key)
            while len(self._values) > self._limit:
                shares = Counter(visitor for visitor, _ in self._values)
                self._values.pop(min(self._values, key=lambda one: -shares[one[0]]))  # the first
        return value

    def _key(self, name: str) -> tuple[str, str]:
        return VISITOR.get() if self._own else "", name
