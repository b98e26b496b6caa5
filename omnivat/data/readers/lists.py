"""Small text files of data sets: tables with a header, JSON, lists of lines."""

import csv
import json
from collections.abc import Sequence
from io import StringIO
from pathlib import Path
from typing import Any

from omnivat.data.readers.names import show
from omnivat.errors import DataError
from omnivat.files import read_whole
from omnivat.tables import suggestion

MOST_TEXT = 1_000_000_000  # bytes of a table or list; a million pairs take 200 MB


def read_text(file: Path) -> str:
    """Return a file as text, with any bytes; raises DataError if it cannot be read."""
    return read_whole(file, MOST_TEXT, show(file)).decode("utf-8-sig", errors="replace")


def read_lines(file: Path) -> list[str]:
    """Return the lines of a file, stripped; empty lines stay."""
    return [line.strip() for line in read_text(file).splitlines()]


def read_json(file: Path, kind: type) -> Any:
    """Return the content of a JSON file; raises DataError for other content."""
    try:
        value = json.loads(read_text(file))
    except (ValueError, RecursionError) as error:
        raise DataError(f"'{show(file)}' is not JSON ({error}). Download it again.") from error
    if not isinstance(value, kind):
        raise DataError(
            f"'{show(file)}' holds a {type(value).__name__}, expected a {kind.__name__}. "
            "It may be another file of the same name."
        )
    return value


def read_cells(file: Path) -> list[list[str]]:
    """Return the rows of a CSV with stripped cells, without empty rows."""
    try:
        rows = [[cell.strip() for cell in row] for row in csv.reader(StringIO(read_text(file)))]
    except csv.Error as error:
        raise DataError(f"'{show(file)}' cannot be read as a CSV ({error}).") from error
    return [row for row in rows if any(row)]


def read_rows(file: Path, needed: Sequence[str]) -> list[dict[str, str]]:
    """Return the rows of a CSV by the names in its first row. Raises DataError without a `needed` one."""
    header, *cells = read_cells(file) or [[]]
    header = [name.lower() for name in header]
    for name in needed:
        if name not in header:
            raise DataError(
                f"'{show(file)}' has no column '{name}'; expected a first row with {', '.join(needed)}."
                f"{suggestion(name, header)}"
            )
    return [dict(zip(header, row, strict=False)) for row in cells]


def read_names(file: Path, key: str, value: str) -> dict[str, str]:
    """Return one named column by another, for a CSV with names in its first row.

    Raises DataError if a column is missing, or a key has two values.
    """
    named: dict[str, str] = {}
    for row in read_rows(file, (key, value)):
        name, text = row.get(key, ""), row.get(value, "")
        if name and named.setdefault(name, text) != text:
            raise DataError(f"'{show(file)}' gives '{show(name)}' two values for {value}. Keep one.")
    return named
