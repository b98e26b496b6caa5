"""Files of data sets: checks of names, frames in a folder, and small tables, JSON and lists."""

import csv
import json
import os
import re
from collections.abc import Iterator, Sequence
from io import StringIO
from pathlib import Path
from typing import Any

from omnivat.kit.errors import DataError, printable
from omnivat.kit.files import read_whole
from omnivat.kit.tables import suggestion

MOST_TEXT = 1_000_000_000  # bytes of a table or list; a million pairs take 200 MB
is_file = os.path.isfile  # unlike Path.is_file, it never raises for long names
SUFFIXES = "png apng jpg jpeg jpe jfif webp bmp dib tif tiff gif ppm pgm pnm tga jp2 j2k avif"
IMAGE_SUFFIXES = frozenset(f".{suffix}" for suffix in SUFFIXES.split())


def show(path: Path | str) -> str:
    """Return a printable path: invalid bytes and line ends become escapes."""
    return printable(os.fspath(path))


def is_text(name: str) -> bool:
    """True if a file name is valid UTF-8."""
    return not any(0xD800 <= ord(letter) <= 0xDFFF for letter in name)


def is_image_name(name: str) -> bool:
    """True if a file's suffix, in any case, is that of an image."""
    return os.path.splitext(name)[1].lower() in IMAGE_SUFFIXES


def visible(folder: Path) -> Iterator[os.DirEntry[str]]:
    """Yield the entries of a folder, sorted by name, without hidden ones.

    A folder that cannot be listed has none.
    """
    try:
        with os.scandir(folder) as entries:
            found = sorted(entries, key=lambda entry: entry.name)
    except OSError:
        return
    yield from (entry for entry in found if not entry.name.startswith("."))


def folders_in(folder: Path) -> list[Path]:
    """Return the visible folders in `folder`; links to folders come after the folders."""
    found = [entry for entry in visible(folder) if os.path.isdir(entry.path)]
    return [folder / entry.name for entry in sorted(found, key=os.DirEntry.is_symlink)]


def leads_upwards(folder: Path) -> bool:
    """True if a link leads to one of its own parent folders."""
    return folder.is_symlink() and Path(os.path.realpath(folder.parent)).is_relative_to(os.path.realpath(folder))


def number_of(path: Path) -> int | None:
    """Return the number at the end of a file's stem, if any."""
    return int(number[0]) if (number := re.search(r"[0-9]+$", path.stem)) else None


def frames_in(folder: Path, suffixes: frozenset[str] = IMAGE_SUFFIXES) -> dict[int, Path]:
    """Return the frames in a folder by the number at the end of their names, in that order.

    If a frame has two formats, the first by name counts. Names without a number are ignored.
    """
    frames: dict[int, Path] = {}
    for entry in visible(folder):
        path = folder / entry.name
        number = number_of(path)
        if number is not None and path.suffix.lower() in suffixes and is_text(entry.name) and is_file(path):
            frames.setdefault(number, path)
    return dict(sorted(frames.items()))


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
