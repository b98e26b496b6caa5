"""Named columns of Parquet files: numbers, texts, and pictures as the package `datasets` writes
them, one in a row or a list of them. A limited process reads them.
"""

import json
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.images import from_array, read_image
from omnivat.data.named_columns import Columns, Pictures, received, require_one, sent
from omnivat.kit.errors import DataError
from omnivat.kit.limited import Limited
from omnivat.kit.tables import need

if TYPE_CHECKING:
    from PIL import Image


def parquet_columns(place: Path) -> Columns:
    """Return the columns of a Parquet file. Raises DataError."""
    names, _ = _read(place, "names")

    def column(name: str) -> NDArray[Any]:
        require_one(place, names.count(name), name)
        return received(*_read(place, "column", name=name))

    def pictures(name: str) -> Pictures | None:
        about, _ = _read(place, "pictures", name=name)
        if not about:
            return None
        require_one(place, names.count(name), name)
        listed = about.pop("listed")

        def one(k: int, t: int) -> "Image.Image":
            what = f"{place.name}, {name}, row {k}" + f", {t}" * listed
            found, content = _read(place, "picture", name=name, row=k, item=t, listed=listed)
            if found:
                return from_array(received(found, content), what)
            if not content:
                raise DataError(
                    f"'{what}' has no picture; write the bytes of its file, not its path."
                )
            return read_image(content, what, reduced=False)

        return Pictures(one=one, **about)

    return Columns(place=place, names=tuple(names), read=column, pictures=pictures)


def parquet_rows(place: Path) -> list[dict[str, Any]]:
    """Return the rows of a Parquet file, without bytes. Raises DataError."""
    return list(_read(place, "rows")[0])


def parquet_cells(place: Path, column: str, episode: int) -> list[bytes]:
    """Return the pictures' files in a column, b"" of none, in the rows of a LeRobot episode.

    Raises DataError.
    """
    sizes, content = _read(place, "cells", column=column, episode=episode)
    ends = np.cumsum(sizes, dtype=np.int64)
    return [content[end - size : end] for size, end in zip(sizes, ends, strict=True)]


def _read(place: Path, what: str, **of: Any) -> tuple[Any, bytes]:
    need("pyarrow.parquet", purpose="reading Parquet", install="pyarrow")
    (found,) = read_part.read(place, what=what, **of)
    return found


def part(_: bytes, *, file: str, what: str, **of: Any) -> tuple[Any, bytes]:
    """Return what is wanted of a file. Runs in the limited process."""
    from pyarrow.parquet import read_table

    if what == "names":
        return _opened(file)[1].names, b""
    if what == "column":
        return sent(_column(file, **of))
    if what == "pictures":
        return _pictures(file, **of), b""
    if what == "picture":
        return _picture(file, **of)
    if what == "rows":
        return read_table(file).to_pylist(), b""
    only = [("episode_index", "=", of["episode"])]
    column = read_table(file, columns=[of["column"]], filters=only).column(0)
    cells = [_content(cell) for cell in column.to_pylist()]
    return [*map(len, cells)], b"".join(cells)


def _content(cell: Any) -> bytes:
    """Return the bytes in a cell, b"" without: a text would be read as a path."""
    content = cell.get("bytes") if isinstance(cell, dict) else cell
    return content if isinstance(content, bytes) else b""


def _opened(file: str) -> tuple[Any, Any]:
    """Return a file and its schema, which are read once: a set may have a column for each number of
    its vectors.
    """
    now = Path(file).stat()
    return _opened_at(file, now.st_mtime_ns, now.st_size)


@lru_cache(maxsize=1)
def _opened_at(file: str, *_: int) -> tuple[Any, Any]:
    from pyarrow.parquet import ParquetFile

    return (handle := ParquetFile(file)), handle.schema_arrow


def _column(file: str, name: str) -> NDArray[Any]:
    table = _opened(file)[0].read(columns=[name])
    column = table.column(0)
    if str(column.type).startswith("dictionary"):  # categories of pandas
        column = column.cast(column.type.value_type)
    if names := _class_names(table.schema.metadata or {}).get(name):
        numbers = column.to_pylist()
        return np.array(
            [names[k] if k is not None and 0 <= k < len(names) else "" for k in numbers]
        )
    return _values(column, name)


def _chunk(handle: Any, number: int, name: str) -> Any:
    cells = handle.read_row_group(number, columns=[name]).column(0).combine_chunks()
    return getattr(cells, "storage", cells)


def _starts(handle: Any) -> list[int]:
    """Return the first row of each group of rows, and the number of all."""
    counts = [handle.metadata.row_group(g).num_rows for g in range(handle.num_row_groups)]
    return [0, *np.cumsum(counts, dtype=np.int64).tolist()]


def _pictures(file: str, name: str) -> dict[str, Any]:
    """Return how many pictures a column has, and of lists their lengths; {} without any."""
    from pyarrow import compute, types

    (handle, schema), depth = _opened(file), 0
    starts, item = _starts(handle), schema.field(schema.get_all_field_indices(name)[0]).type
    item = getattr(item, "storage_type", item)
    while hasattr(item, "value_type"):
        item, depth = item.value_type, depth + 1
    listed = depth == (4 if types.is_integer(item) else 1)

    def first() -> list[Any]:
        cells = _chunk(handle, 0, name)[:1].to_pylist() if len(starts) > 1 else []
        return [value for cell in cells for value in (cell if listed else [cell])]

    if not _holds_pictures(item, depth - listed, first):
        return {}
    lengths: list[int] = []
    for number in range(len(starts) - 1) if listed else ():
        counts = compute.list_value_length(_chunk(handle, number, name)).to_pylist()
        lengths += [length or 0 for length in counts]
    return {"rows": starts[-1], "lengths": lengths, "listed": listed}


def _picture(file: str, name: str, row: int, item: int, listed: bool) -> tuple[Any, bytes]:
    """Return the bytes of a picture's file, or its pixels."""
    changed = Path(file).stat().st_mtime_ns
    starts = _first_rows(file, changed)
    number = int(np.searchsorted(starts, row, side="right")) - 1
    cell = _group(file, changed, name, number)[row - starts[number]]
    cell = cell[item] if listed else cell
    content = cell.get("bytes") if isinstance(cell, dict) else cell
    return sent(np.array(content)) if isinstance(content, list) else ({}, _content(cell))


@lru_cache(maxsize=2)
def _first_rows(file: str, _: int) -> list[int]:
    return _starts(_opened(file)[0])


@lru_cache(maxsize=2)  # rows are read in order, of two columns
def _group(file: str, _: int, name: str, number: int) -> list[Any]:
    return list(_chunk(_opened(file)[0], number, name).to_pylist())


def _class_names(metadata: dict[bytes, bytes]) -> dict[str, list[str]]:
    """Return the names of numbered classes that the package `datasets` keeps in a file."""
    try:
        features = json.loads(metadata[b"huggingface"])["info"]["features"]
        found = {n: f["names"] for n, f in features.items() if f.get("_type") == "ClassLabel"}
        return {name: [*map(str, names)] for name, names in found.items()}
    except (KeyError, ValueError, TypeError, AttributeError):
        return {}


def _holds_pictures(kind: Any, depth: int, first: Callable[[], list[Any]]) -> bool:
    """Return whether lists, `depth` of them in each other, of a type of Arrow are pictures; bytes
    are looked at.
    """
    from pyarrow import types

    if depth:
        return depth in (2, 3) and types.is_integer(kind)
    if types.is_struct(kind):
        return "bytes" in {kind.field(k).name for k in range(kind.num_fields)}
    if types.is_binary(kind) or types.is_large_binary(kind):
        try:
            return all(read_image(cell or b"", "it") is not None for cell in first())
        except DataError:
            return False
    return False


def _values(column: Any, name: str) -> NDArray[Any]:
    """Return a column of Arrow: rows of numbers as one array (N, D), and anything else as it is,
    with "" for what is missing.
    """
    from pyarrow import compute

    if not hasattr(column.type, "value_type") or hasattr(column.type.value_type, "value_type"):
        cells = ["" if value is None else value for value in column.to_pylist()]
        if any(isinstance(cell, (dict, list)) for cell in cells[:1]):
            raise ValueError(f"it has no numbers or texts in {name}")
        return np.array(cells)
    lengths = [length or 0 for length in compute.list_value_length(column).to_pylist()]
    first = next((row for row, length in enumerate(lengths) if length), 0)
    for row, length in enumerate(lengths):
        if length != lengths[first]:
            raise ValueError(
                f"it has {f'{length} numbers' if length else 'nothing'} in row {row} of {name}, and"
                f" {lengths[first]} in row {first}, and every row needs as many"
            )
    flat = compute.list_flatten(column).to_numpy()
    return np.asarray(flat).reshape(len(lengths), -1)


read_part = Limited(f"{__name__}:part", seconds=30, grows=True)
