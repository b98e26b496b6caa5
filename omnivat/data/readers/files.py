"""Files of data sets: checks of names, frames in a folder, and small tables, JSON and lists."""

import codecs
import csv
import os
import re
import zipfile
from collections import Counter
from collections.abc import Container, Iterator, Sequence
from contextlib import suppress
from io import StringIO
from pathlib import Path
from typing import Any

from omnivat.data.naming import COLUMNS, SUFFIXES, composed, is_file_name
from omnivat.kit.errors import DataError, printable
from omnivat.kit.files import read_cell, read_whole
from omnivat.kit.limited import Limited
from omnivat.kit.tables import need, suggestion

MOST_TEXT = 1_000_000_000  # bytes of a table or list; a million pairs take 200 MB
is_file = os.path.isfile  # unlike Path.is_file, it never raises for long names
TABLES = (".csv", ".tsv", ".xlsx")
TITLES = 10  # rows in which a table's header is looked for
DELIMITERS = ",;\t|"
# a formula without a value in a part of an .xlsx; a text (str) may be empty
NEVER_COMPUTED = re.compile(rb'<c (?![^>]*t="str")[^>]*><f[^>]*>[^<]*</f>(<v ?/>|<v></v>)?</c>')
WINDOWS = "cp1252"  # of tables that are not UTF-8: what spreadsheets in Western Europe write


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


def frames_in(folder: Path, suffixes: Container[str] = SUFFIXES) -> dict[int, Path]:
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
    content = read_whole(file, MOST_TEXT, show(file))
    wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))  # "Unicode text" of Excel
    return content.decode("utf-16" if wide else "utf-8-sig", errors="replace")


def table_text(file: Path) -> tuple[str, str]:
    """Return the text of a table and its encoding: UTF-8, UTF-16 or, where neither fits,
    Windows-1252. Raises DataError for bytes that are no text in these.
    """
    content = read_whole(file, MOST_TEXT, show(file))
    few = len(content[:200]) // 4  # a zero in every other byte
    low, high = content[1:200:2].count(0) > few, content[:200:2].count(0) > few
    bom = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))  # "Unicode text" of Excel
    wide = "utf-16" if bom else "utf-16-le" if low else "utf-16-be" if high else ""
    for encoding in (wide, "utf-8-sig", WINDOWS):
        with suppress(UnicodeDecodeError):
            if encoding:
                text = content.decode(encoding)
                if encoding != WINDOWS or "\0" not in text:
                    return text, encoding
    raise DataError(f"'{show(file)}' is not UTF-8 text. Save it as 'CSV UTF-8'.")


def table_note(file: Path) -> str:
    """Return a note on a table that is not in Unicode, or not the sheet that is shown first."""
    if file.suffix.lower() == ".xlsx":
        name, first, _ = _sheet(file)
        return f"sheet '{show(name)}'" if name != first else ""
    old = table_text(file)[1] == WINDOWS
    return "read as Windows-1252, as it is not UTF-8" if old else ""


def read_lines(file: Path) -> list[str]:
    """Return the lines of a file, stripped; empty lines stay."""
    return [line.strip() for line in read_text(file).splitlines()]


def delimiter_of(text: str) -> str:
    """Return the comma, semicolon, tab or bar that separates the cells of a table's first line.

    >>> delimiter_of("vis;tac;material"), delimiter_of('"a;b",c'), delimiter_of("vis")
    (';', ',', ',')
    """
    first = re.sub(r'"[^"]*"', "", text.partition("\n")[0])
    return max(DELIMITERS, key=first.count)


def numbered_rows(file: Path) -> dict[int, list[str]]:
    """Return the rows of a table by their lines, with stripped cells and without empty rows: a CSV
    with commas, semicolons, tabs or bars, or of an .xlsx the first sheet that names files, else the
    one that is shown.

    Raises DataError for a file that cannot be read.
    """
    if file.suffix.lower() == ".xlsx":
        _, _, rows = _sheet(file)
    else:
        text, _ = table_text(file)
        hint = text[:4].lower() == "sep="  # a line for spreadsheets alone
        text = text.partition("\n")[2] if hint else text
        reader = csv.reader(StringIO(text, newline=""), delimiter=delimiter_of(text), strict=True)
        try:
            rows = {line: row for row in reader if (line := reader.line_num + hint)}
        except csv.Error as error:
            raise DataError(
                f"'{show(file)}' cannot be read as a CSV after line {reader.line_num} ({error})."
                " Look for a quotation mark that is not closed."
            ) from error
    stripped = {
        line: [read_cell(composed(cell).strip()) for cell in row] for line, row in rows.items()
    }
    return {line: row for line, row in stripped.items() if any(row)}


def _sheet(file: Path) -> tuple[str, str, dict[int, list[str]]]:
    """Return a sheet's name, that of the sheet that is shown, and the sheet's rows by their lines;
    each cell of merged ones has their text.
    """
    need("openpyxl", purpose="reading .xlsx; or save the table as CSV")
    ((found, _),) = read_sheet.read(file, "save it as CSV")
    rows = dict(zip(found["lines"], found["rows"], strict=True))
    return found["name"], found["first"], rows


def sheet(_: bytes, *, file: str) -> tuple[dict[str, Any], bytes]:
    """Return what `_sheet` does. Runs in the limited process."""
    openpyxl = need("openpyxl", purpose="reading .xlsx")
    book = openpyxl.load_workbook(file, data_only=True)
    shown = book.active
    for chosen in [shown, *(other for other in book.worksheets if other is not shown), shown]:
        # by cell: a sheet that is used up to its last row has a million empty ones
        cells = {at: str(c.value) for at, c in chosen._cells.items() if c.value is not None}
        if any(map(is_file_name, cells.values())):
            break
    if _lacks_values(file):
        formulas = openpyxl.load_workbook(file)[chosen.title]._cells
        lines = [at[0] for at, c in formulas.items() if c.data_type == "f" and at not in cells]
        if lines:
            raise DataError(
                f"'{show(file)}' has a formula in line {min(lines)} that was never computed; open"
                " it in a spreadsheet and save it there."
            )
    for merged in chosen.merged_cells.ranges:
        text = cells.get((merged.min_row, merged.min_col))
        cells.update(dict.fromkeys(merged.cells, text) if text else {})
    rows: dict[int, list[str]] = {}
    for row, column in sorted(cells):
        line = rows.setdefault(row, [])
        line += [""] * (column - 1 - len(line)) + [cells[row, column]]
    names = {"name": chosen.title, "first": shown.title}
    return {**names, "lines": list(rows), "rows": list(rows.values())}, b""


def _lacks_values(file: str) -> bool:
    """True if any sheet of an .xlsx has a formula without a value."""
    with zipfile.ZipFile(file) as parts:
        sheets = [name for name in parts.namelist() if name.startswith("xl/worksheets/")]
        return any(NEVER_COMPUTED.search(parts.read(name)) for name in sheets)


read_sheet = Limited(f"{__name__}:sheet", seconds=30)


def read_rows(file: Path, needed: Sequence[str] = ()) -> dict[int, dict[str, str]]:
    """Return the rows of a person's own table, by their lines and the names in its first row.

    Rows above these with one cell, such as a title, do not count. Of columns of one name, the
    second is called "name (2)".
    Raises DataError without a `needed` name, for another encoding, for a quotation mark that is not
    closed, and for a row with more cells than there are names.
    """
    rows = numbered_rows(file)
    filled = {line: sum(map(bool, row)) for line, row in [*rows.items()][:TITLES]}
    for line in filled:
        if filled[line] > 1 or max(filled.values()) < 2:
            break
        del rows[line]
    lower = [name.lower() for name in rows.pop(next(iter(rows), 0), [])]
    before = Counter[str]()  # a table may have 100,000 columns
    header = []
    for name in lower:
        before[name] += bool(name)
        header.append(f"{name} ({before[name]})" if before[name] > 1 else name)
    for name in needed:
        if name not in header:
            raise DataError(
                f"'{show(file)}' has no column '{name}'; its first row has"
                f" {show(', '.join(header) or 'no names')}, expected"
                f" {', '.join(needed)}.{suggestion(name, header)}"
            )
    for line, row in rows.items():
        if any(row[len(header) :]):
            raise DataError(
                f"'{show(file)}' has more cells in line {line} than in its first row; a comma"
                " inside a name needs quotation marks."
            )
    return {
        line: dict(zip(header, row + [""] * len(header), strict=False))
        for line, row in rows.items()
    }


def read_labels(file: Path, key: str) -> dict[str, dict[str, str]]:
    """Return the labels in a person's own table by its column `key`, under the names used here.

    Raises DataError as `read_rows`.
    """
    ours = {theirs: name for name, all in COLUMNS.items() for theirs in all}
    found = {}
    for row in read_rows(file, (key,)).values():
        plain = {re.sub(r"[\s-]+", "_", name): cell for name, cell in row.items()}
        renamed = {ours[name]: cell for name, cell in plain.items() if name in ours}
        found[row[key].removesuffix(".0")] = renamed | row  # a spreadsheet's 1.0 is 1
    return found


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
