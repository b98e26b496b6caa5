"""Named columns of a file, read one by one, of numbers, texts or pictures."""

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from omnivat.kit.errors import DataError, OmniVatError, first_line
from omnivat.kit.limited import GROWTH, MEMORY

if TYPE_CHECKING:
    from PIL import Image


@dataclass(frozen=True, slots=True, kw_only=True)
class Pictures:
    """The pictures of a column.

    rows     their number; 0: a single picture
    one      gives the picture of a row, or of a place in the list of a row
    lengths  of the lists, if each row has one
    """

    rows: int
    one: "Callable[[int, int], Image.Image]"
    lengths: Sequence[int] = ()


@dataclass(frozen=True, kw_only=True)
class Columns:
    """The columns of a file, read one by one.

    read        gives a column by its name, with any error of its format
    pictures    gives the pictures of a column, or None for one of anything else
    attributes  gives those of a group or a column of HDF5
    lines       of the rows in a table of text
    """

    place: Path
    names: tuple[str, ...]
    read: Callable[[str], NDArray[Any]]
    pictures: Callable[[str], Pictures | None]
    attributes: Callable[[str], Mapping[str, Any]] = lambda _: {}
    lines: Sequence[int] = ()

    def get(self, name: str) -> NDArray[Any] | None:
        """Return a column, `name_0`, `name_1`, ... as one array (N, D), or the only column of that
        name in a group; None if there is none. Raises DataError.
        """
        with explained(self.place):
            if path := self.path(name):
                return self.read(path)
            pattern = rf"{re.escape(name)}_(\d+)"
            found = {
                int(m[1]): key for key in self.names if (m := re.fullmatch(pattern, key, re.I))
            }
            numbers = sorted(found)
            if not numbers:
                return None
            if numbers != list(range(numbers[0], numbers[0] + len(numbers))):
                raise DataError(
                    f"'{self.place}' lacks some of the columns {name}_{numbers[0]} to"
                    f" {name}_{numbers[-1]}."
                )
            return np.stack([self.read(found[k]) for k in numbers], axis=1)

    def path(self, name: str) -> str:
        """Return the full name of a column, which may lie in a group and be written as a person
        does, such as "Object ID" for object_id; "" of none or several.
        """
        near = self.alike(name)
        if name in near:
            return name
        ends = [key for key in near if key.rpartition("/")[2] == name]
        found = ends or [key for key in near if _plain(key.rpartition("/")[2]) == name]
        return found[0] if len(found) == 1 else ""

    def alike(self, name: str) -> Sequence[str]:
        """Return the full names that end as `name`, in capitals or not."""
        return self._by_end.get(_plain(name.rpartition("/")[2]), ())

    @cached_property
    def _by_end(self) -> dict[str, list[str]]:  # a file may have 100,000
        found: dict[str, list[str]] = defaultdict(list)
        for name in self.names:
            found[_plain(name.rpartition("/")[2])].append(name)
        return found

    def pictures_of(self, name: str) -> Pictures | None:
        """Return the pictures of a column, if it has any. Raises DataError."""
        with explained(self.place):
            return self.pictures(path) if (path := self.path(name)) else None

    def row(self, number: int) -> str:
        """Return the name of a row in a message."""
        return f"row {number}" + (f" (line {self.lines[number]})" if self.lines else "")


def sent(array: NDArray[Any]) -> tuple[dict[str, Any], bytes]:
    """Return an array as JSON and bytes, of objects as texts; `received` turns them back."""
    array = array.astype(str) if array.dtype.kind == "O" else array
    return {"dtype": array.dtype.str, "shape": array.shape}, array.tobytes()


def received(about: Mapping[str, Any], content: bytes) -> NDArray[Any]:
    return np.frombuffer(content, about["dtype"]).reshape(about["shape"])


def require_one(place: Path, count: int, name: str) -> None:
    """Raise DataError if several columns of a file have a name; `count` do."""
    if count > 1:
        raise DataError(f"'{place}' has {count} columns called {name}; rename or leave out some.")


def require_room(place: Path, size: int, what: str) -> None:
    """Raise DataError if `what` a file holds, or what is made of it, would take `size` bytes, far
    more than the file has.
    """
    if size > (most := MEMORY + GROWTH * place.stat().st_size):
        raise DataError(
            f"'{place}' would take {size / 1e9:.1f} GB of memory for {what}, and a file of its size"
            f" has {most / 1e9:.1f} GB; split it into several."
        )


def _plain(name: str) -> str:
    return re.sub(r"[\s-]+", "_", name.strip().casefold())


@contextmanager
def explained(place: Path) -> "Iterator[None]":
    try:
        yield
    except OmniVatError:
        raise
    except Exception as error:  # each format has its own errors for damaged files
        raise DataError(
            f"'{place}' cannot be read ({first_line(error)}); export it again."
        ) from error
