"""A CSV of pairs: one row for each pair, columns vis and tac (one of the two is enough), and
optional ones.
"""

import os
from pathlib import Path
from typing import Any

from omnivat.data.materials import MATERIALS, NO_CLASS, class_key
from omnivat.data.pairs import TEXTS, Pair, PairSet, Skipped
from omnivat.data.readers.files import is_file, modality_of, read_rows, show
from omnivat.kit.errors import DataError
from omnivat.kit.tables import suggestion

NEEDED = ("vis", "tac", "domain", "material")  # in each row, but a table may lack some of them
OTHER = {"vis": "tac", "tac": "vis"}  # one that is absent: the same picture stands for both
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
    for number, row in _rows(file).items():
        texts: dict[str, Any] = {name: class_key(row.get(name, "")) for name in TEXTS}
        pair = Pair(
            vis=_path(file.parent, row["vis"]),
            tac=_path(file.parent, row["tac"]),
            domain=row["domain"],
            material=class_key(row["material"]),
            **texts | {"object": row.get("object", "")},
        )
        why = _why_not(file, number, row, pair, strict)
        if not why:
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


def _rows(file: Path) -> dict[int, Row]:
    """Return the rows by their lines, with what the table leaves to be known."""
    rows = read_rows(file)
    filled = {name for row in rows.values() for name, cell in row.items() if cell}
    if "material" not in filled and (other := filled & {"class", "label"}):
        (material, *_), filled = sorted(other), filled | {"material"}
        rows = {line: row | {"material": row[material]} for line, row in rows.items()}
    others = filled - {*NEEDED, *TEXTS}
    absent = [name for name in NEEDED if name not in filled]
    for name in absent if rows else ():
        meant = suggestion(name, others)
        if meant or not OTHER.keys() & filled:
            raise DataError(
                f"'{show(file)}' has no column '{name}'; its first row has"
                f" {show(', '.join(next(iter(rows.values()))))}, expected vis and tac, and perhaps"
                f" domain, material, {', '.join(TEXTS)}, separated by commas.{meant}"
            )
    known = {"domain": file.resolve().parent.name or "pictures", "material": NO_CLASS}
    for row in rows.values():
        for name in absent:
            row[name] = known[name] if name in known else row[OTHER[name]]
        row["alone"] = next((OTHER[name] for name in absent if name in OTHER), "")
    return rows


def _why_not(file: Path, number: int, row: Row, pair: Pair, strict: bool) -> str:
    """Return why a row gives no pair, or ""."""
    for name in NEEDED:
        if not row[name]:
            return f"'{name}' is empty"
    if strict and pair.material not in MATERIALS:
        return f"strict: not one of {', '.join(MATERIALS)}"
    for name in OTHER:
        if not is_file(getattr(pair, name)):
            return f"the {name} image is not there"
    touch = modality_of(pair.tac) == "tac"
    if row["alone"] and touch != (row["alone"] == "tac"):
        return "a picture alone, whose name tells a touch: NAME_tac.png, or in a folder tac"
    if pair.split and pair.split not in SPLITS:
        raise DataError(
            f"'{show(file)}', row {number}: there is no split '{show(row['split'])}'; "
            f"expected {', '.join(SPLITS)} or nothing.{suggestion(pair.split, SPLITS)}"
        )
    return ""


def _path(folder: Path, cell: str) -> Path:
    """Return the path in a cell; backslashes work, too."""
    path = folder / cell
    return path if is_file(path) else folder / cell.replace("\\", "/")
