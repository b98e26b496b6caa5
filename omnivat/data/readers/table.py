"""A CSV of pairs: one row for each pair, columns vis and tac (one of the two is enough), and
optional ones.
"""

import csv
import os
from collections.abc import Iterator
from io import StringIO
from pathlib import Path

from omnivat.data.materials import MATERIALS, NO_CLASS, class_key
from omnivat.data.pairs import Pair, PairSet, Skipped
from omnivat.data.readers.files import MOST_TEXT, is_file, is_text, modality_of, show
from omnivat.kit.errors import DataError
from omnivat.kit.files import read_whole
from omnivat.kit.tables import suggestion

NEEDED = ("vis", "tac", "domain", "material")  # in each row, but a table may lack some of them
OPTIONAL = ("object", "split", "part", "looks_like", "feels_like")
OTHER = {"vis": "tac", "tac": "vis"}  # one that is absent: the same picture stands for both
SAME = {"class": "material", "label": "material"}  # other names of a column
SPLITS = ("train", "val", "test")
Row = dict[str, str]


def recognises(source: Path) -> bool:
    """True for a CSV, or for a folder with a pairs.csv."""
    return source.suffix.lower() == ".csv" if is_file(source) else is_file(source / "pairs.csv")


def read(source: Path, *, strict: bool = False, seed: int = 0) -> PairSet:
    """Return the pairs of a CSV in UTF-8, separated by commas, with names in its first row.

    source  the file, or a folder with `pairs.csv`; its paths are relative to its folder
    strict  keep the five materials only
    seed    not used: every pair is kept

    Without domains, the table's folder names it; without material (or class, or label)
    there are no classes; of vis or tac alone, each picture stands for both. A row without an image
    or a name, or a repeated row, is skipped and listed. Raises DataError for another kind of file,
    an unknown split, the same images under two names, or no pairs.
    """
    file = source / "pairs.csv" if source.is_dir() else source
    pairs: list[Pair] = []
    skipped: list[Skipped] = []
    first: dict[tuple[str, str], tuple[int, Pair]] = {}  # the two files -> row of first appearance
    for number, row in _rows(file):
        why = _why_not(file, number, row, strict)
        if not why:
            pair = _pair(file.parent, row)
            files = (os.path.abspath(pair.vis), os.path.abspath(pair.tac))
            earlier, same = first.setdefault(files, (number, pair))
            if earlier == number:
                pairs.append(pair)
                continue
            for name in ("domain", "material"):
                here, there = getattr(pair, name), getattr(same, name)
                if here != there:
                    raise DataError(
                        f"'{show(file)}' gives the same two images the {name} '{show(there)}' in"
                        f" row {earlier} and '{show(here)}' in row {number}. Keep the right one."
                    )
            why = "repeats an earlier row"
        skipped.append(Skipped(what=f"row {number}", why=why))
    if not pairs:
        first_reason = f" The first reason, {skipped[0].what}: {skipped[0].why}." if skipped else ""
        raise DataError(
            f"No pairs in '{show(file)}': none of its {len(skipped)} rows can be"
            f" used.{first_reason}"
        )
    return PairSet(pairs=tuple(pairs), skipped=tuple(skipped), origin=f"table '{file.name}'")


def _rows(file: Path) -> Iterator[tuple[int, Row]]:
    """Yield the rows with their spreadsheet numbers and stripped cells."""
    try:
        text = read_whole(file, MOST_TEXT, show(file)).decode("utf-8-sig")
        reader = csv.reader(StringIO(text, newline=""), strict=True)
        header = [name.strip().lower() for name in next(reader, [])]
        if "material" not in header:
            header = [SAME.get(name, name) for name in header]
        _check_header(file, header)
        rows = [(number, [*map(str.strip, cells)]) for number, cells in enumerate(reader, start=2)]
        filled = {
            name for _, cells in rows for name, cell in zip(header, cells, strict=False) if cell
        }
        absent = set(NEEDED) - filled
        names = {"domain": file.resolve().parent.name or "pictures", "material": NO_CLASS}
        for number, cells in rows:
            if any(cells):
                row = dict(zip(header, cells, strict=False))
                row |= {name: names[name] for name in absent & names.keys()}
                row |= {name: row.get(OTHER[name], "") for name in absent & OTHER.keys()}
                row["alone"] = next((OTHER[name] for name in absent & OTHER.keys()), "")
                row["more"] = "yes" if len(cells) > len(header) else ""
                yield number, row
    except csv.Error as error:
        raise DataError(
            f"'{show(file)}' cannot be read as a CSV after line {reader.line_num} ({error}). "
            "Look for a quotation mark that is not closed."
        ) from error
    except UnicodeDecodeError as error:
        raise DataError(
            f"'{show(file)}' is not UTF-8 text (byte {error.start}). Save it as 'CSV UTF-8'."
        ) from error


def _check_header(file: Path, header: list[str]) -> None:
    for separator, word in ((";", "semicolons"), ("\t", "tabs")):
        if len(header) == 1 and separator in header[0]:
            raise DataError(f"'{show(file)}' separates its columns by {word}. Save it with commas.")
    twice = [name for name in (*NEEDED, *OPTIONAL) if header.count(name) > 1]
    if twice:
        raise DataError(f"'{show(file)}' has the column '{twice[0]}' twice. Remove one.")
    others = [name for name in header if name not in (*NEEDED, *OPTIONAL)]
    for name in NEEDED:
        meant = suggestion(name, others)
        if name not in header and (meant or not OTHER.keys() & header):
            there = show(", ".join(filter(None, header)) or "no names")
            raise DataError(
                f"'{show(file)}' has no column '{name}'; its first row has {there}, expected vis"
                f" and tac, and perhaps domain, material, {', '.join(OPTIONAL)}.{meant}"
            )


def _why_not(file: Path, number: int, row: Row, strict: bool) -> str:
    """Return why a row gives no pair, or ""."""
    if row["more"]:
        return "has more cells than the first row (a comma inside a name needs quotation marks)"
    for name in NEEDED:
        if not row.get(name):
            return f"'{name}' is empty"
    if strict and class_key(row["material"]) not in MATERIALS:
        return f"strict: not one of {', '.join(MATERIALS)}"
    for name in ("vis", "tac"):
        if not is_file(_path(file.parent, row[name])):
            return f"the {name} image is not there"
    touch = modality_of(_path(file.parent, row["tac"])) == "tac"
    if row["alone"] and touch != (row["alone"] == "tac"):
        return "a picture alone, whose name tells a touch: NAME_tac.png, or in a folder tac"
    if not is_text(str(_path(file.parent, row["vis"])) + str(_path(file.parent, row["tac"]))):
        return "the folder's name is not UTF-8; rename it"
    split = row.get("split", "").lower()
    if split and split not in SPLITS:
        raise DataError(
            f"'{show(file)}', row {number}: there is no split '{show(row['split'])}'; "
            f"expected {', '.join(SPLITS)} or nothing.{suggestion(split, SPLITS)}"
        )
    return ""


def _path(folder: Path, cell: str) -> Path:
    """Return the path in a cell; backslashes work, too."""
    path = folder / cell
    return path if is_file(path) else folder / cell.replace("\\", "/")


def _pair(folder: Path, row: Row) -> Pair:
    return Pair(
        vis=_path(folder, row["vis"]),
        tac=_path(folder, row["tac"]),
        domain=row["domain"],
        material=class_key(row["material"]),
        object=row.get("object", ""),
        split=row.get("split", "").lower(),
        part=row.get("part", "").lower(),
        looks_like=class_key(row.get("looks_like", "")),
        feels_like=class_key(row.get("feels_like", "")),
    )
