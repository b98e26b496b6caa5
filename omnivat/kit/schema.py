"""Check untrusted files before loading them.

JSON must have limited depth, numbers of limited length and valid texts. A safetensors file must
have a header of limited size, few names and expected types. Every error is one sentence.
"""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from omnivat.kit.errors import DataError, printable
from omnivat.kit.files import read_whole

DEEPEST = 40
LONGEST_INTEGER = 18  # digits
LONGEST_NAME = 300
MOST_JSON = 8_000_000  # bytes of settings or metrics
MOST_HEADER = 8_000_000  # bytes of a safetensors header
MOST_TENSORS = 4096
MOST_AXES = 8
TYPES = ("F64", "F32", "F16", "BF16", "I64", "I32", "I16", "I8", "U8", "BOOL")


def read_object(file: Path) -> dict[str, Any]:
    """Return the JSON object in a file; raises DataError for anything else."""
    return object_in(read_whole(file, MOST_JSON), str(file))


def object_in(content: bytes, name: str) -> dict[str, Any]:
    """Return the JSON object in bytes.

    name  their name in errors
    Raises DataError for anything else, and for deep nesting, integers of many digits, infinite
    numbers, or texts with lone surrogates.
    """
    value = json_in(content, name)
    if not isinstance(value, dict):
        raise DataError(f"'{name}' should hold a JSON object.")
    return value


def json_in(content: bytes, name: str) -> Any:
    """Return the JSON value in bytes; raises DataError as `object_in` does."""
    try:
        value = json.loads(content, parse_int=_integer, parse_float=_float)
        _require_plain(value, DEEPEST)
    except (ValueError, RecursionError) as error:
        why = "it is nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise DataError(f"'{name}' is not readable JSON ({printable(why):.200}).") from error
    return value


def _integer(text: str) -> int:
    if len(text) > LONGEST_INTEGER:
        raise ValueError(f"a whole number of {len(text)} digits")
    return int(text)


def _float(text: str) -> float:
    value = float(text)
    if math.isinf(value):
        raise ValueError(f"the number {text[:20]}")
    return value


def _require_plain(value: Any, deeper: int) -> None:
    """Raise an error for deep nesting, and for texts that UTF-8 cannot encode."""
    if deeper < 0:
        raise ValueError(f"it is nested more than {DEEPEST} deep")
    if isinstance(value, str):
        try:
            value.encode()
        except UnicodeEncodeError as error:  # a lone surrogate, which no file or page can contain
            raise ValueError(f"a text with half a character, {value[:20]!r}") from error
    elif isinstance(value, dict):
        _require_plain([*value, *value.values()], deeper)
    elif isinstance(value, list):
        for inner in value:
            _require_plain(inner, deeper - 1)


def texts(value: Any, name: str) -> dict[str, str]:
    """Return a mapping of texts to texts; raises DataError for anything else."""
    if not isinstance(value, dict) or not all(isinstance(item, str) for item in value.values()):
        raise DataError(f"'{name}' should hold texts under names, not {_kind(value)}.")
    return value


def name_list(value: Any, name: str, most: int) -> tuple[str, ...]:
    """Return a list of different, short, non-empty names; raises DataError for anything else."""
    good = isinstance(value, list) and all(
        isinstance(n, str)
        and 0 < len(n) <= LONGEST_NAME
        and n.encode(errors="ignore").decode() == n
        for n in value
    )
    if not good or len(value) > most or len(set(value)) < len(value):
        raise DataError(
            f"'{name}' should be a list of up to {most:,} different names of 1 to {LONGEST_NAME} "
            f"letters, not {_kind(value)}."
        )
    return tuple(value)


def columns_in(content: bytes, name: str, most: int) -> dict[str, list[str]]:
    """Return columns of texts from JSON bytes; there may be millions of texts. Raises DataError
    for anything else.
    """
    try:
        columns = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise DataError(f"'{name}' cannot be read (no JSON: {error!s:.100}).") from error
    if not isinstance(columns, dict) or len(columns) > most:
        raise DataError(f"'{name}' should be a JSON object of up to {most} columns.")
    for title, column in columns.items():
        try:
            if not isinstance(column, list):
                raise TypeError
            for start in range(0, max(1, len(column)), 10_000):
                "".join([title, *column[start : start + 10_000]]).encode()
        except (TypeError, UnicodeEncodeError) as error:
            why = "is not a list of texts that can be written; make the file again."
            raise DataError(f"Column {title!a:.60} of '{name}' {why}") from error
    return columns


def _kind(value: Any) -> str:
    if isinstance(value, dict | list):
        return f"a {'mapping' if isinstance(value, dict) else 'list'} of {len(value):,}"
    return f"{value!r:.40}"


def tensor_table(
    file: Path, *, types: tuple[str, ...] = TYPES, most: int = MOST_TENSORS
) -> tuple[dict[str, Mapping[str, Any]], dict[str, str], int]:
    """Return the table of a safetensors file, its metadata, and the offset of its numbers.

    types  accepted number types
    most   largest number of names
    Raises DataError for a truncated, too large or inconsistent header.
    """
    with file.open("rb") as handle:
        length = int.from_bytes(handle.read(8), "little")
        if length > MOST_HEADER:
            raise DataError(
                f"'{file}' cannot be read (a header of {length:,} bytes, and {MOST_HEADER:,} are "
                "read); it is damaged, or no safetensors file."
            )
        text = handle.read(length)
    if len(text) < length or text.count(b'"data_offsets"') > most:
        much = "it is cut short" if len(text) < length else f"it names more than {most:,} arrays"
        raise DataError(f"'{file}' cannot be read ({much}); copy it again.")
    table = object_in(text, f"{file} (header)")
    metadata = texts(table.pop("__metadata__", {}), f"{file} (metadata)")
    for name, entry in table.items():
        if not _is_entry(entry, types):
            raise DataError(
                f"'{file}' cannot be read ('{name:.60}' is no array of {', '.join(types)}); copy it"
                " again."
            )
    return table, metadata, 8 + length


def _is_entry(entry: Any, types: tuple[str, ...]) -> bool:
    match entry:
        case {"dtype": str(kind), "shape": [*shape], "data_offsets": [first, last]}:
            sizes = [*shape, first, last]
            return (
                kind in types
                and len(shape) <= MOST_AXES
                and all(type(n) is int and n >= 0 for n in sizes)
            )
    return False
