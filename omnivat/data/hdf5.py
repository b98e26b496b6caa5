"""Arrays of an HDF5 file, read in a limited process: on a damaged file, the format's library may
loop for ever or end its process.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.named_columns import received, sent
from omnivat.kit.limited import Limited
from omnivat.kit.tables import need


@dataclass(frozen=True, slots=True, kw_only=True)
class Stored:
    """An array of a file; an index reads a part of it, and `[()]` all of it."""

    file: Path
    name: str
    shape: tuple[int, ...]
    dtype: "np.dtype[Any]"
    of_bytes: bool  # uint8, or rows of uint8 that may differ in length

    @property
    def ndim(self) -> int:
        return len(self.shape)

    @property
    def size(self) -> int:
        return prod(self.shape)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, where: Any) -> NDArray[Any]:
        """Return names of an enumeration in place of its numbers, and texts as such. Raises
        DataError if the part cannot be read.
        """
        index = [*map(int, where)] if isinstance(where, tuple) else [int(where)]
        (found,) = read_part.read(self.file, name=self.name, where=index)
        return np.array(found[0]["texts"]) if "texts" in found[0] else received(*found)


def arrays(file: Path) -> tuple[dict[str, Stored], Mapping[str, Mapping[str, Any]]]:
    """Return the arrays by their full names, and the attributes of groups and arrays, "" for those
    of the file; in place of a value that is no single text or number stands [].

    Raises DataError for a damaged file, MissingPackageError without h5py.
    """
    need("h5py", purpose="reading HDF5")
    ((found, _),) = read_part.read(file)
    stored = {
        name: Stored(
            file=file, name=name, shape=tuple(shape), dtype=np.dtype(kind), of_bytes=of_bytes
        )
        for name, (shape, kind, of_bytes) in found["arrays"].items()
    }
    return stored, found["attributes"]


def part(
    _: bytes, *, file: str, name: str = "", where: list[int] | None = None
) -> tuple[dict[str, Any], bytes]:
    """Return shape, type and attributes of all arrays, or with a `name` the values of that array.

    where  start of the index: the first axes are fixed

    Runs in the limited process.
    """
    import h5py

    with h5py.File(file, "r") as handle:
        if name:
            return _values(h5py, handle[name], tuple(where or ()))
        found: dict[str, Any] = {}
        attributes = {"": _attributes(handle)}

        def visit(name: str, item: Any) -> None:
            attributes[name] = _attributes(item)
            if hasattr(item, "dtype"):
                if item.external or item.is_virtual:  # which may be any file, or be missing
                    raise ValueError(f"the values of {name} lie in other files")
                inner = h5py.check_vlen_dtype(item.dtype) or item.dtype
                found[name] = item.shape or (), item.dtype.str, bool(inner == np.uint8)

        handle.visititems(visit)
        filled = {name: own for name, own in attributes.items() if own}
        return {"arrays": found, "attributes": filled}, b""


def _attributes(item: Any) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in item.attrs:
        with suppress(Exception):  # of a type that h5py lacks
            value = np.asarray(item.attrs[name])
            plain = value.reshape(-1)[0].item() if value.size == 1 else []
            if isinstance(plain, bytes):
                plain = plain.decode(errors="replace")
            found[name] = plain if isinstance(plain, str | int | float) else []
    return found


def _values(h5py: Any, own: Any, where: tuple[int, ...]) -> tuple[dict[str, Any], bytes]:
    if names := h5py.check_enum_dtype(own.dtype):
        by_number = {number: label for label, number in names.items()}
        return {"texts": np.vectorize(lambda k: by_number.get(k, ""))(own[where]).tolist()}, b""
    if h5py.check_string_dtype(own.dtype):
        texts = own.asstr()[where]
        return {"texts": texts.tolist() if isinstance(texts, np.ndarray) else texts}, b""
    if own.dtype.kind == "O" and len(where) < own.ndim:
        raise ValueError(f"the rows of {own.name} differ in length")
    return sent(np.asarray(own[where]))


read_part = Limited(f"{__name__}:part", seconds=10, grows=True)
