"""Read and write `.safetensors` files that need not fit in memory.

The safetensors package reads and writes whole arrays. Here, arrays are memory-mapped for reading
and written block by block. The format: 8 bytes with the length of a JSON table, the table, the
numbers.
"""

import json
import mmap
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from safetensors import safe_open

from omnivat.kit.errors import DataError
from omnivat.kit.schema import tensor_table

NAMES = {"float32": "F32", "float16": "F16", "int64": "I64", "uint8": "U8"}  # of numpy -> stored
MOST_COLUMNS = 64
MOST, LEAST = 1e9, 1e-6  # magnitudes of the largest value of a set
LARGE_BYTES = 64_000_000  # larger arrays are mapped read-only
WALKED_BYTES = 32_000_000  # bytes read from such an array before its pages are released


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """An array to write: type, shape, and lazy blocks of its first axis."""

    dtype: np.dtype[Any]  # whose name is a key of NAMES
    shape: tuple[int, ...]
    blocks: Iterable[NDArray[Any]]


def column(array: NDArray[Any]) -> Column:
    """Return a column of an array in memory."""
    return Column(dtype=array.dtype, shape=array.shape, blocks=(array,))


def write_arrays(path: Path, columns: Mapping[str, Column], metadata: Mapping[str, str]) -> None:
    """Write named columns, with one block in memory at a time.

    Raises ValueError if the blocks of a column do not add up to its shape.
    """
    table: dict[str, Any] = {"__metadata__": dict(metadata)}
    # Widest numbers first, so that every array starts at a multiple of its own width.
    order, end = sorted(columns.items(), key=lambda item: -item[1].dtype.itemsize), 0
    for name, entry in order:
        start, end = end, end + entry.dtype.itemsize * int(np.prod(entry.shape, dtype=np.int64))
        table[name] = {
            "dtype": NAMES[entry.dtype.name],
            "shape": list(entry.shape),
            "data_offsets": [start, end],
        }
    head = json.dumps(table, ensure_ascii=False, separators=(",", ":")).encode()
    head += b" " * (-len(head) % 8)
    with path.open("wb") as handle:
        handle.write(len(head).to_bytes(8, "little") + head)
        for name, entry in order:
            start, end = table[name]["data_offsets"]
            for block in entry.blocks:
                start += handle.write(
                    block.astype(entry.dtype.newbyteorder("<"), copy=False).tobytes()
                )
            if start != end:
                raise ValueError(f"{name} has {end - start} bytes less than {entry.shape} needs")


def read_arrays(
    path: Path, *, large: int | None = None
) -> tuple[dict[str, NDArray[Any]], dict[str, str]]:
    """Return named memory-mapped arrays and the metadata.

    large  bytes up to which an array is writable in memory, without changing the file; None:
           LARGE_BYTES

    Raises DataError for an invalid header, SafetensorError for a truncated file.
    """
    table, metadata, start = tensor_table(path, types=tuple(NAMES.values()), most=MOST_COLUMNS)
    with safe_open(path, framework="numpy"):  # checks offsets, shapes and file size
        pass
    large = LARGE_BYTES if large is None else large
    return {name: _mapped(path, start, entry, large) for name, entry in table.items()}, metadata


def released(array: NDArray[Any]) -> None:
    """Release a mapped array's pages; they are read again when needed.

    Changes to the array in memory are lost, so use it only for unchanged arrays.
    """
    mapped = getattr(array, "_mmap", None)
    if mapped is not None and hasattr(mapped, "madvise"):
        mapped.madvise(mmap.MADV_DONTNEED)


def copied(array: NDArray[Any]) -> NDArray[np.float32]:
    """Return all vectors in memory, in single precision."""
    whole = np.array(array, np.float32)
    if not array.flags.writeable:
        released(array)
    return whole


def row_numbers(rows: Any, count: int) -> NDArray[np.int64]:
    """Return numbers of rows, of `count`, or those where a mask is true. Raises DataError."""
    with suppress(Exception):  # an object of others may raise any
        found = np.asarray(rows)
        if found.dtype == bool and found.shape == (count,):
            return np.flatnonzero(found)
        whole = found.dtype.kind in "iu" or not found.size
        if whole and found.ndim == 1 and bool(((found >= -count) & (found < count)).all()):
            return found.astype(np.int64)
    raise DataError(f"Rows are whole numbers below {count} in one list; others were given.")


def walked(
    array: NDArray[Any], rows: NDArray[np.int64] | None = None, *, size: int = 4096
) -> Iterator[NDArray[Any]]:
    """Yield copies of an array's rows, `size` at a time, without keeping a large array in memory.

    rows    indices; None: every row
    return  blocks in single precision where the array has half
    """
    wide = np.dtype(np.float32) if array.dtype == np.float16 else array.dtype
    count, read = len(array) if rows is None else len(rows), 0
    if rows is not None and not array.flags.writeable:
        size = min(size, 256)  # scattered rows map whole pages and their neighbours
    for start in range(0, count, size):
        some: Any = slice(start, start + size) if rows is None else rows[start : start + size]
        block = np.array(array[some], wide)
        read += array[:1].nbytes * (
            len(block) if rows is None else int(some.max() - some.min() + 1)
        )
        if read >= WALKED_BYTES or start + size >= count:
            read = 0
            if not array.flags.writeable:
                released(array)
        yield block


def require_range(blocks: Iterable[NDArray[Any]], what: str) -> Iterator[NDArray[Any]]:
    """Yield blocks of rows (N, D) whose largest magnitude is 0 or in [LEAST, MOST].

    Squares of other values overflow or vanish in single precision, and figures would be wrong
    without a warning. Raises DataError with the row and column of a value that is too large.
    """
    start, largest = 0, 0.0
    for block in blocks:
        size = np.abs(block)
        if not (size <= MOST).all():  # also true of NaN
            row, at = np.argwhere(~(size <= MOST))[0].tolist()
            raise DataError(
                f"{what} has {block[row, at]:g} in row {start + row}, column {at}, where"
                f" magnitudes up to {MOST:g} are accepted; check the encoder, or scale all rows."
            )
        largest, start = max(largest, float(size.max(initial=0))), start + len(block)
        yield block
    if 0 < largest < LEAST:
        raise DataError(
            f"{what} has no value above {largest:.2g}; scale all rows until one is {LEAST:g} or"
            " more."
        )


def _mapped(path: Path, start: int, entry: Mapping[str, Any], large: int) -> NDArray[Any]:
    code = next(np.dtype(name) for name in NAMES if NAMES[name] == entry["dtype"])
    code, shape = code.newbyteorder("<"), tuple(entry["shape"])
    first, end = entry["data_offsets"]
    if first == end:
        return np.empty(shape, code)
    mode: Literal["r", "c"] = "r" if end - first > large else "c"
    return np.memmap(path, dtype=code, mode=mode, offset=start + first, shape=shape)
