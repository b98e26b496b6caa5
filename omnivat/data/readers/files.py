"""Files of data sets: checks of names, frames in a folder, and small tables, JSON and lists."""

import csv
import os
import re
from collections.abc import Iterator, Sequence
from io import StringIO
from pathlib import Path

from omnivat.kit.errors import DataError, printable
from omnivat.kit.files import read_whole
from omnivat.kit.stages import IMAGES
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


def encodable(text: str, what: str) -> str:
    """Return a text that can be written; raise DataError for one with half of a surrogate pair."""
    if not is_text(text):
        raise DataError(f"{what} is '{show(text[:60])}', which no file can hold; correct it.")
    return text


def number_in(value: object, low: float, high: float, what: str) -> float:
    """Return a finite number from `low` to `high`, or a text of one; raise DataError for
    anything else.
    """
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        number = float("nan")
    if not low <= number <= high:  # also true of NaN
        raise DataError(
            f"{what} is {printable(repr(value)[:40])}; it has to be a number from {low:g} to"
            f" {high:g}."
        )
    return number


def is_image_name(name: str) -> bool:
    """True if a file's suffix, in any case, is that of an image."""
    return os.path.splitext(name)[1].lower() in IMAGE_SUFFIXES


def modality_of(path: Path) -> str:
    """Return "vis" or "tac" by the end of a file's stem or its folder's name; "" for neither."""
    stem, folder = path.stem.lower(), path.parent.name.lower()
    return next((n for n in IMAGES if stem == n or stem.endswith(f"_{n}") or folder == n), "")


def modalities_of(vis: Sequence[Path | str], tac: Sequence[Path | str]) -> tuple[str, ...]:
    """Return the modalities of pairs by the names of their pictures: one if the same picture stands
    for both.
    """
    if list(vis) != list(tac) or not any(map(str, vis)):
        return IMAGES
    return ("tac",) if all(modality_of(Path(name)) == "tac" for name in vis) else ("vis",)


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
        if (
            number is not None
            and path.suffix.lower() in suffixes
            and is_text(entry.name)
            and is_file(path)
        ):
            frames.setdefault(number, path)
    return dict(sorted(frames.items()))


def read_text(file: Path) -> str:
    """Return a file as text, with any bytes; raises DataError if it cannot be read."""
    return read_whole(file, MOST_TEXT, show(file)).decode("utf-8-sig", errors="replace")


def read_lines(file: Path) -> list[str]:
    """Return the lines of a file, stripped; empty lines stay."""
    return [line.strip() for line in read_text(file).splitlines()]


def read_cells(file: Path) -> list[list[str]]:
    """Return the rows of a CSV with stripped cells, without empty rows."""
    try:
        rows = [[cell.strip() for cell in row] for row in csv.reader(StringIO(read_text(file)))]
    except csv.Error as error:
        raise DataError(f"'{show(file)}' cannot be read as a CSV ({error}).") from error
    return [row for row in rows if any(row)]


def read_rows(file: Path, needed: Sequence[str] = ()) -> dict[int, dict[str, str]]:
    """Return the rows of a person's own CSV, by their lines and the names in its first row.

    Raises DataError without a `needed` name, for another encoding, for a quotation mark that is not
    closed, and for a row with more cells than there are names.
    """
    text = read_text(file)
    reader = csv.DictReader(StringIO(text, newline=""), restval="", strict=True)
    try:
        header = [name.strip().lower() for name in reader.fieldnames or ()]
        reader.fieldnames = header
        rows = [(reader.line_num, row) for row in reader]
    except csv.Error as error:
        raise DataError(
            f"'{show(file)}' cannot be read as a CSV after line {reader.line_num} ({error}). "
            "Look for a quotation mark that is not closed."
        ) from error
    if "\ufffd" in text:
        raise DataError(f"'{show(file)}' is not UTF-8 text. Save it as 'CSV UTF-8'.")
    for name in needed:
        if name not in header:
            raise DataError(
                f"'{show(file)}' has no column '{name}'; its first row has"
                f" {show(', '.join(header) or 'no names')}, expected {', '.join(needed)}, separated"
                f" by commas.{suggestion(name, header)}"
            )
    for line, row in rows:
        if None in row:
            raise DataError(
                f"'{show(file)}' has more cells in line {line} than in its first row; a comma"
                " inside a name needs quotation marks."
            )
    return {
        line: {name: cell.strip() for name, cell in row.items()}
        for line, row in rows
        if any(map(str.strip, row.values()))
    }


def read_names(file: Path, key: str, value: str) -> dict[str, str]:
    """Return one named column by another, for a CSV with names in its first row.

    Raises DataError if a column is missing, or a key has two values.
    """
    named: dict[str, str] = {}
    for row in read_rows(file, (key, value)).values():
        name, text = row[key], row[value]
        if name and named.setdefault(name, text) != text:
            raise DataError(
                f"'{show(file)}' gives '{show(name)}' two values for {value}. Keep one."
            )
    return named
