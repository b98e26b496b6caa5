"""Named columns in files of other programs: NPZ, Parquet, HDF5, safetensors, or a table of text.

Only the columns that are needed are opened, so others may hold anything. No code in a file is run.
"""

import json
import re
import zipfile
from collections.abc import Callable, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from safetensors import deserialize, safe_open

from omnivat.data.images import from_array, read_image
from omnivat.data.readers.files import TABLES, numbered_rows
from omnivat.kit.errors import DataError, OmniVatError, first_line
from omnivat.kit.files import require_regular
from omnivat.kit.tables import need

if TYPE_CHECKING:
    from collections.abc import Iterator

    from PIL import Image

Picture = "Callable[[int], Image.Image]"


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """The columns of a file, read one by one.

    read      gives a column by its name, with any error of its format
    pictures  gives a function from a row to its picture, or None for a column of anything else
    lines     of the rows in a table of text
    """

    place: Path
    names: tuple[str, ...]
    read: Callable[[str], NDArray[Any]]
    pictures: "Callable[[str], tuple[int, Callable[[int], Image.Image]] | None]"
    lines: Sequence[int] = ()

    def get(self, name: str) -> NDArray[Any] | None:
        """Return a column, `name_0`, `name_1`, ... as one array (N, D), or the only column of that
        name in a group; None if there is none. Raises DataError.
        """
        with _explained(self.place):
            if path := self.path(name):
                return self.read(path)
            pattern = rf"{re.escape(name)}_(\d+)"
            numbers = sorted(int(m[1]) for key in self.names if (m := re.fullmatch(pattern, key)))
            if not numbers:
                return None
            if numbers != list(range(numbers[0], numbers[0] + len(numbers))):
                raise DataError(
                    f"'{self.place}' lacks some of the columns {name}_{numbers[0]} to"
                    f" {name}_{numbers[-1]}."
                )
            return np.stack([self.read(f"{name}_{k}") for k in numbers], axis=1)

    def path(self, name: str) -> str:
        """Return the full name of a column, which may lie in a group, or ""."""
        ends = [key for key in self.names if key.rpartition("/")[2] == name]
        return name if name in self.names else ends[0] if len(ends) == 1 else ""

    def pictures_of(self, name: str) -> "tuple[int, Callable[[int], Image.Image]] | None":
        """Return the number of rows and a function from a row to its picture, if a column has
        pictures. Raises DataError.
        """
        with _explained(self.place):
            return self.pictures(path) if (path := self.path(name)) else None

    def row(self, number: int) -> str:
        """Return the name of a row in a message."""
        return f"row {number}" + (f" (line {self.lines[number]})" if self.lines else "")


@contextmanager
def _explained(place: Path) -> "Iterator[None]":
    try:
        yield
    except OmniVatError:
        raise
    except Exception as error:  # each format has its own errors for damaged files
        raise DataError(
            f"'{place}' cannot be read ({first_line(error)}); export it again."
        ) from error


def columns_of(place: Path) -> Columns:
    """Return the columns of a file; its ending gives the format.

    Raises DataError if it is missing, of another kind or unreadable, MissingPackageError if the
    package for it is not installed.
    """
    require_regular(place)
    reader = READERS.get(place.suffix.lower())
    if reader is None:
        raise DataError(f"'{place}' ends in '{place.suffix}'; there are {', '.join(READERS)}.")
    with _explained(place):
        return reader(place)


def _of_array(array: Any, place: Path, name: str) -> Any:
    """Return the number of pictures in an array (N, H, W) or with channels, and a reader."""
    if array.ndim not in (3, 4) or array.dtype.kind not in "uf":
        return None
    return len(array), lambda k: from_array(np.asarray(array[k]), f"{place.name}, {name}, row {k}")


def _npz(place: Path) -> Columns:
    if not zipfile.is_zipfile(place):
        raise DataError(f"'{place}' is not an NPZ file; write it with numpy.savez.")

    def read(name: str) -> NDArray[Any]:
        with np.load(place, allow_pickle=False) as arrays:
            try:
                return np.asarray(arrays[name])
            except ValueError as error:
                raise DataError(
                    f"'{place}' holds pickled objects in {name}, which are not read; save one array"
                    " of numbers, or of str."
                ) from error

    with np.load(place, allow_pickle=False) as arrays:
        names = tuple(arrays.files)
    return Columns(
        place=place, names=names, read=read, pictures=lambda n: _of_array(read(n), place, n)
    )


def _safetensors(place: Path) -> Columns:
    def read(name: str) -> NDArray[Any]:
        with safe_open(place, framework="numpy") as file:
            if file.get_slice(name).get_dtype() != "BF16":  # which NumPy lacks
                return np.asarray(file.get_tensor(name))
        content = place.read_bytes()
        tensor = dict(deserialize(content))[name]  # type: ignore[no-untyped-call]
        upper = np.frombuffer(tensor["data"], "<u2").astype("<u4") << 16
        return upper.view("<f4").reshape(tensor["shape"])

    with safe_open(place, framework="numpy") as file:
        names = tuple(file.keys())
    return Columns(
        place=place, names=names, read=read, pictures=lambda n: _of_array(read(n), place, n)
    )


def _hdf5(place: Path) -> Columns:
    h5py = need("h5py", purpose="reading HDF5")

    def read(name: str) -> NDArray[Any]:
        with h5py.File(place, "r") as file:
            dataset = file[name]
            text = h5py.check_string_dtype(dataset.dtype)
            if names := h5py.check_enum_dtype(dataset.dtype):
                by_number = {number: one for one, number in names.items()}
                return np.array([by_number.get(k, "") for k in dataset[()].tolist()])
            if dataset.dtype.kind == "O" and not text:
                raise DataError(f"'{place}' has rows of differing lengths in {name}.")
            return np.asarray(dataset.asstr()[()] if text else dataset[()])

    def pictures(name: str) -> Any:
        def one(k: int) -> "Image.Image":
            with h5py.File(place, "r") as file:
                cell, what = file[name][k], f"{place.name}, {name}, row {k}"
            if cell.ndim == 1:  # the bytes of a picture's file
                return read_image(cell.tobytes(), what, reduced=False)
            return from_array(cell, what)

        with h5py.File(place, "r") as file:
            dataset = file[name]
            found = _of_array(dataset, place, name)
            inner = h5py.check_vlen_dtype(dataset.dtype) or dataset.dtype
            if inner == np.uint8 and (dataset.ndim + (dataset.dtype.kind == "O")) == 2:
                with suppress(DataError):
                    found = read_image(dataset[0].tobytes(), name) and (len(dataset), None)
        return found and (found[0], one)

    names: list[str] = []
    with h5py.File(place, "r") as file:
        file.visititems(lambda name, one: names.append(name) if hasattr(one, "dtype") else None)
    return Columns(place=place, names=tuple(names), read=read, pictures=pictures)


def _text(place: Path) -> Columns:
    rows = numbered_rows(place)
    header = rows.pop(next(iter(rows), 0), [])
    for number, (line, row) in enumerate(rows.items()):
        if len(row) != len(header) and any(row[len(header) :] or row[-1:]):
            raise DataError(
                f"'{place}' has {len(row)} cells in row {number} (line {line}), and"
                f" {len(header)} in its first row."
            )
    cells = [row + [""] * (len(header) - len(row)) for row in rows.values()]

    def read(name: str) -> NDArray[Any]:
        at = header.index(name)
        return np.array([row[at] for row in cells])

    return Columns(
        place=place, names=tuple(header), read=read, pictures=lambda name: None, lines=list(rows)
    )


def _parquet(place: Path) -> Columns:
    parquet = need("pyarrow.parquet", purpose="reading Parquet", install="pyarrow")
    file = parquet.ParquetFile(place)
    schema = file.schema_arrow
    classes = _class_names(schema.metadata or {})
    starts = np.cumsum(
        [0, *(file.metadata.row_group(g).num_rows for g in range(file.num_row_groups))]
    )

    def read(name: str) -> NDArray[Any]:
        column = parquet.read_table(place, columns=[name]).column(0)
        if str(column.type).startswith("dictionary"):  # categories of pandas
            column = column.cast(column.type.value_type)
        if names := classes.get(name):
            numbers = column.to_pylist()
            return np.array(
                [names[k] if k is not None and 0 <= k < len(names) else "" for k in numbers]
            )
        return _values(column, name, place)

    @lru_cache(maxsize=2)  # rows are read in order
    def group(number: int, name: str) -> list[Any]:
        return list(file.read_row_group(number, columns=[name]).column(0).to_pylist())

    def pictures(name: str) -> Any:
        kind = schema.field(name).type
        if not _holds_pictures(kind, lambda: group(0, name)[:1] if len(starts) > 1 else []):
            return None

        def one(k: int) -> "Image.Image":
            number = int(np.searchsorted(starts, k, side="right")) - 1
            cell = group(number, name)[k - starts[number]]
            content = cell.get("bytes") if isinstance(cell, dict) else cell
            what = f"{place.name}, {name}, row {k}"
            if isinstance(content, list):
                return from_array(np.array(content), what)
            if not isinstance(content, bytes) or not content:  # a text would be read as a path
                raise DataError(f"'{what}' has no picture.")
            return read_image(content, what, reduced=False)

        return int(starts[-1]), one

    return Columns(place=place, names=tuple(schema.names), read=read, pictures=pictures)


def _class_names(metadata: dict[bytes, bytes]) -> dict[str, list[str]]:
    """Return the names of numbered classes that the package `datasets` keeps in a file."""
    try:
        features = json.loads(metadata[b"huggingface"])["info"]["features"]
        found = {n: f["names"] for n, f in features.items() if f.get("_type") == "ClassLabel"}
        return {name: [*map(str, names)] for name, names in found.items()}
    except (KeyError, ValueError, TypeError, AttributeError):
        return {}


def _holds_pictures(kind: Any, first: Callable[[], list[Any]]) -> bool:
    """Return whether a type of Arrow is that of pictures; bytes are looked at."""
    types = need("pyarrow.types", purpose="reading Parquet", install="pyarrow")
    if types.is_struct(kind):
        return "bytes" in {kind.field(k).name for k in range(kind.num_fields)}
    if types.is_binary(kind) or types.is_large_binary(kind):
        try:
            return all(read_image(cell or b"", "it") is not None for cell in first())
        except DataError:
            return False
    depth = 0
    while hasattr(kind, "value_type"):
        kind, depth = kind.value_type, depth + 1
    return depth in (2, 3) and types.is_integer(kind)


def _values(column: Any, name: str, place: Path) -> NDArray[Any]:
    """Return a column of Arrow: rows of numbers as one array (N, D), and anything else as it is,
    with "" for what is missing.
    """
    if not hasattr(column.type, "value_type") or hasattr(column.type.value_type, "value_type"):
        cells = ["" if value is None else value for value in column.to_pylist()]
        if any(isinstance(cell, (dict, list)) for cell in cells[:1]):
            raise DataError(f"'{place}' has no numbers or texts in {name}.")
        return np.array(cells)
    compute = need("pyarrow.compute", purpose="reading Parquet", install="pyarrow")
    lengths = [one or 0 for one in compute.list_value_length(column).to_pylist()]
    first = next((row for row, length in enumerate(lengths) if length), 0)
    for row, length in enumerate(lengths):
        if length != lengths[first]:
            raise DataError(
                f"'{place}' has {f'{length} numbers' if length else 'nothing'} in row {row} of"
                f" {name}, and {lengths[first]} in row {first}; every row needs as many."
            )
    flat = compute.list_flatten(column).to_numpy()
    return np.asarray(flat).reshape(len(lengths), -1)


READERS: dict[str, Callable[[Path], Columns]] = {
    ".npz": _npz,
    ".parquet": _parquet,
    ".h5": _hdf5,
    ".hdf5": _hdf5,
    ".safetensors": _safetensors,
    **dict.fromkeys(TABLES, _text),
}
