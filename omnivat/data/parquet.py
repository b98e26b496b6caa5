"""Named columns of Parquet files: numbers, texts, and pictures as the package `datasets` writes
them, one in a row or a list of them.
"""

import json
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.images import from_array, read_image
from omnivat.data.named_columns import Columns, Pictures, require_one
from omnivat.kit.errors import DataError
from omnivat.kit.tables import need

if TYPE_CHECKING:
    from PIL import Image


def parquet_columns(place: Path) -> Columns:
    """Return the columns of a Parquet file, with any error of pyarrow."""
    parquet = need("pyarrow.parquet", purpose="reading Parquet", install="pyarrow")
    file = parquet.ParquetFile(place)
    schema = file.schema_arrow
    compute = need("pyarrow.compute", purpose="reading Parquet", install="pyarrow")
    types = need("pyarrow.types", purpose="reading Parquet", install="pyarrow")
    classes = _class_names(schema.metadata or {})
    starts = np.cumsum(
        [0, *(file.metadata.row_group(g).num_rows for g in range(file.num_row_groups))]
    )

    def read(name: str) -> NDArray[Any]:
        require_one(place, schema.names, name)
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
        return list(column(number, name).to_pylist())

    def column(number: int, name: str) -> Any:
        cells = file.read_row_group(number, columns=[name]).column(0).combine_chunks()
        return getattr(cells, "storage", cells)

    def pictures(name: str) -> Pictures | None:
        kind = schema.types[schema.names.index(name)]
        kind = getattr(kind, "storage_type", kind)

        def first() -> list[Any]:
            require_one(place, schema.names, name)
            cells = column(0, name)[:1].to_pylist() if len(starts) > 1 else []
            return [one for cell in cells for one in (cell if listed else [cell])]

        item, depth = kind, 0
        while hasattr(item, "value_type"):
            item, depth = item.value_type, depth + 1
        listed = depth == (4 if types.is_integer(item) else 1)
        if not _holds_pictures(item, depth - listed, first):
            return None
        require_one(place, schema.names, name)

        def one(k: int, t: int) -> "Image.Image":
            number = int(np.searchsorted(starts, k, side="right")) - 1
            cell = group(number, name)[k - starts[number]]
            cell = cell[t] if listed else cell
            content = cell.get("bytes") if isinstance(cell, dict) else cell
            what = f"{place.name}, {name}, row {k}" + f", {t}" * listed
            if isinstance(content, list):
                return from_array(np.array(content), what)
            if not isinstance(content, bytes) or not content:  # a text would be read as a path
                raise DataError(
                    f"'{what}' has no picture; write the bytes of its file, not its path."
                )
            return read_image(content, what, reduced=False)

        lengths: list[int] = []
        for number in range(len(starts) - 1) if listed else ():
            counts = compute.list_value_length(column(number, name))
            lengths += [length or 0 for length in counts.to_pylist()]
        return Pictures(rows=int(starts[-1]), one=one, lengths=lengths)

    return Columns(place=place, names=tuple(schema.names), read=read, pictures=pictures)


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
    types = need("pyarrow.types", purpose="reading Parquet", install="pyarrow")
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
