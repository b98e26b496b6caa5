"""References in requests: a pair of the set, an example, or an uploaded image.

Of uploaded images, the server keeps only embeddings, named by a hash of their content. Two visitors
share an entry only if they upload the same image.
"""

from collections import OrderedDict
from dataclasses import dataclass
from hashlib import blake2b
from threading import Lock
from typing import Any, Generic, TypeVar

from omnivat.errors import DataError
from omnivat.orders import optional_order


class ForgottenError(DataError):
    """The server no longer has an uploaded image; the page sends it again."""

    status = 410


KINDS = ("row", "example", "image")
LONGEST_NAME = 200
V = TypeVar("V")


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
            f"'{value}' names no image; expected one of "
            + ", ".join(f"'{kind}:…'" for kind in KINDS)
            + "."
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
    """The most recently used values, at most `limit` of them; safe between threads."""

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._values: OrderedDict[str, V] = OrderedDict()
        self._lock = Lock()

    def get(self, name: str) -> V | None:
        """Return the value called `name`, or None if it is not kept."""
        with self._lock:
            if name in self._values:
                self._values.move_to_end(name)
            return self._values.get(name)

    def keep(self, name: str, value: V) -> V:
        """Keep `value`; drop the least recently used one beyond the limit."""
        with self._lock:
            self._values[name] = value
            self._values.move_to_end(name)
            while len(self._values) > self._limit:
                self._values.popitem(last=False)
        return value
