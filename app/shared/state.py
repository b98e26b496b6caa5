"""Images in requests (of a pair of the set, of an example, or a visitor's own), and what the server
keeps.

Of a visitor's images the server keeps nothing: a reply has the embeddings of the pictures that came
with a request, and later requests have them in the pictures' place. Of what it does keep, a visitor
finds only what came from its own address.
"""

from base64 import b64decode, b64encode
from collections import OrderedDict
from collections.abc import Callable, Collection, Mapping
from contextvars import ContextVar
from dataclasses import dataclass
from functools import partial
from hashlib import blake2b
from threading import Lock
from typing import Any, Generic, TypeVar

from omnivat.kit.errors import DataError
from omnivat.kit.progress import checkpoint
from omnivat.kit.stages import optional_order


class ForgottenError(DataError):
    """The server no longer has what a visitor loaded by name; the page sends it again."""

    status = 410


Question = Mapping[str, Any]  # a request
Reply = dict[str, Any]  # a JSON object
KINDS = ("row", "example", "image")
LONGEST_NAME = 200
LONGEST_IMAGE = 100_000  # letters; an embedding of 1,280 numbers has 6,827
V = TypeVar("V")
order_from = partial(optional_order, name="p")  # None if none is given
# address of the visitor whose job runs here; "" for the server's own work
VISITOR: ContextVar[str] = ContextVar("visitor", default="")


@dataclass(frozen=True, slots=True)
class InTwo:
    """A reply in two lines of JSON: what a visitor waits for, and the work that gives the rest."""

    first: Reply
    rest: Callable[[], Reply]


class Unread(str):
    """Stands for a picture that came with a request and cannot be read: the sentence why."""


@dataclass(frozen=True, slots=True)
class Ref:
    """One image: `row:12` of the set, `example:TAG-sim/wood/a`, or a visitor's own by its
    embeddings, `image:<encoder>:<float32 numbers in base64>`.
    """

    kind: str
    name: str

    def __str__(self) -> str:
        return f"{self.kind}:{self.name}"

    @classmethod
    def of_numbers(cls, encoder: str, numbers: bytes) -> "Ref":
        """Return a visitor's image by the bytes of its embeddings."""
        return cls("image", f"{encoder}:{b64encode(numbers).decode()}")

    def numbers(self, encoder: str) -> bytes:
        """Return the bytes of a visitor's image. Raises ForgottenError for those of another
        encoder, DataError for what is no base64.
        """
        of, _, text = self.name.partition(":")
        if of != encoder:
            raise ForgottenError("Another encoder has read this image; choose its file again.")
        try:
            return b64decode(text, validate=True)
        except ValueError as error:
            raise DataError("The numbers of an image are damaged; send its file.") from error


def ref_from(value: Any) -> Ref | None:
    """Return the image reference in a request; None if it is left out. Raises DataError for
    anything else.
    """
    if value is None or value == "":
        return None
    if isinstance(value, Unread):
        raise DataError(value)
    most = LONGEST_IMAGE if isinstance(value, str) and value.startswith("image:") else LONGEST_NAME
    if not isinstance(value, str) or len(value) > most:
        raise DataError("An image is named by a short text such as 'row:12'; choose one again.")
    kind, colon, name = value.partition(":")
    if kind not in KINDS or not colon or not name:
        known = ", ".join(f"'{kind}:…'" for kind in KINDS)
        raise DataError(f"'{value:.60}' names no image; expected one of {known}.")
    return Ref(kind, name)


def one_of(name: str, value: Any, known: Collection[Any]) -> Any:
    """Return a choice in a request. Raises DataError if it is none of `known`."""
    if isinstance(value, bool) or not isinstance(value, str | int) or value not in known:
        choices = ", ".join(str(choice) for choice in known if choice != "")
        raise DataError(f"{name} is {value!r:.40}; choose one of {choices}.")
    return value


def content_name(content: bytes) -> str:
    """Return a hash of bytes, used as a name."""
    return blake2b(content, digest_size=16).hexdigest()


class Lazy(Generic[V]):
    """Holds the result of `make`, computed on first use by any thread. After a failure, the next
    use tries again.
    """

    def __init__(self, make: Callable[[], V]) -> None:
        self._make, self._lock = make, Lock()
        self._made: list[V] = []

    def __call__(self) -> V:
        if not self._made:
            with self._lock:
                if not self._made:
                    self._made.append(self._make())
        return self._made[0]


class Recent(Generic[V]):
    """The most recently used values, at most `limit` of them; safe between threads.

    private  a visitor finds only its own values
    room     the most bytes of all values; the newest may be above
    """

    def __init__(self, limit: int, *, private: bool = False, room: int = 0) -> None:
        self._limit, self._private, self._room = limit, private, room
        self._values: OrderedDict[tuple[str, str], tuple[V, int]] = OrderedDict()  # value, bytes
        self._lock = Lock()

    def get(self, name: str) -> V | None:
        """Return the value called `name`, or None if it is not kept."""
        key = self._key(name)
        with self._lock:
            if key not in self._values:
                return None
            self._values.move_to_end(key)
            return self._values[key][0]

    def values(self) -> list[V]:
        """Return what is kept, of all visitors."""
        with self._lock:
            return [value for value, _ in self._values.values()]

    def keep(self, name: str, value: V, size: int = 0) -> list[V]:
        """Keep `value` of `size` bytes; return the values that are dropped for it."""
        dropped: list[V] = []
        key = self._key(name)
        with self._lock:
            self._values[key] = value, size
            self._values.move_to_end(key)
            while len(self._values) > 1 and (
                len(self._values) > self._limit or 0 < self._room < self._bytes()
            ):
                dropped.append(self._values.popitem(last=False)[1][0])
        return dropped

    def once(self, name: str, make: Callable[[], V], size: int = 0) -> V:
        """Return the value called `name`; make and keep it if it is not kept."""
        kept = self.get(name)
        if kept is None:
            checkpoint()
            self.keep(name, kept := make(), size)
        return kept

    def _bytes(self) -> int:
        return sum(size for _, size in self._values.values())

    def _key(self, name: str) -> tuple[str, str]:
        return VISITOR.get() if self._private else "", name
