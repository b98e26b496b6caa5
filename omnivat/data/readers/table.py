"""A table of pairs: one row for each pair, columns vis and tac (one of the two is enough), and
optional ones.
"""

import os
import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from omnivat.data.materials import MATERIALS, NO_CLASS, class_key
from omnivat.data.naming import (
    COLUMNS,
    SPLIT_COLUMNS,
    checked_split,
    found_file,
    half_of,
    is_file_name,
    modality_of,
    one_spelling,
    set_name,
    split_of,
)
from omnivat.data.numbers import are_numbers
from omnivat.data.pairs import TEXTS, Pair, PairSet, Skipped
from omnivat.data.readers.files import TABLES, is_file, read_rows, show, table_note
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES
from omnivat.kit.tables import suggestion

WORDS = {"vis": "photos", "tac": "touches"}
OTHER = {"vis": "tac", "tac": "vis"}
BEFORE = "tac_before"  # column of the touches of a moment before
TIMES = {  # of films -> other names of theirs
    "start": ("start_time", "start_s", "begin", "onset"),
    "end": ("end_time", "end_s", "stop"),
    "tac_delay": ("touch_delay", "delay"),
}
OWN = (BEFORE, *TIMES, "named", "vis_from", "tac_from")  # of our own tables
RARE = 0.1  # share of rows without a picture up to which they are left out
Row = dict[str, str]


def recognises(source: Path) -> bool:
    """True for a table, or for a folder with a pairs.csv."""
    return source.suffix.lower() in TABLES if is_file(source) else is_file(source / "pairs.csv")


def read(
    source: Path, *, strict: bool = False, seed: int = 0, vis: str = "", tac: str = ""
) -> PairSet:
    """Return the pairs of a table with commas, semicolons, tabs or bars, or of an .xlsx, with
    names in its first row.

    source    the file, or a folder with `pairs.csv`; its paths are relative to its folder
    strict    keep the five materials only
    seed      not used: every pair is kept
    vis, tac  names of the columns of photos and touches; "": found by their words

    Without domains, the table's folder names it; without material (or class, or label) there are
    no classes. Where more than a tenth of the rows have one picture alone, it stands for both, and
    the set has the modality that every row has; fewer such rows are left out. A row without an
    image or a name, or a repeated row, is left out and listed. `tac_before` names the touch of a
    moment before, for encoders that take several frames.
    Raises DataError for another kind of file, an unknown split, the same images under two names, or
    no pairs.
    """
    file = source / "pairs.csv" if source.is_dir() else source
    pairs: list[Pair] = []
    skipped: list[Skipped] = []
    first: dict[tuple[str, str], tuple[int, Pair]] = {}  # the two files -> row of first appearance
    rows, columns = rows_of(file, vis=vis, tac=tac)
    for row in rows.values():
        if row["vis"] == row["tac"]:  # one picture, in both columns
            row[OTHER[modality_of(Path(row["vis"])) or "vis"]] = ""
    alone = _stands_for_both(list(rows.values()))
    measured = _numbers(list(rows.values()))
    for number, row in rows.items():
        texts: dict[str, Any] = {name: class_key(row.get(name, "")) for name in TEXTS}
        pair = Pair(
            vis=found_file(file.parent, row["vis"] or row["tac"]),
            tac=found_file(file.parent, row["tac"] or row["vis"]),
            domain=row["domain"],
            material=class_key(row["material"]),
            alone=alone if not all(row[half] for half in IMAGES) else "",
            tac_before=found_file(file.parent, before) if (before := row.get(BEFORE)) else None,
            numbers=tuple((name, row.get(name, "")) for name in measured),
            **texts
            | {
                "object": row.get("object", ""),
                "split": checked_split(texts["split"], f"'{show(file)}', row {number}"),
            },
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
    origin = ", ".join(filter(None, (f"table '{file.name}'", columns)))
    return PairSet(pairs=tuple(pairs), skipped=tuple(skipped), origin=origin)


def _numbers(rows: list[Row]) -> list[str]:
    """Return the columns that hold numbers and have no other meaning here."""
    meant = {*COLUMNS, *TEXTS, *IMAGES, *(name for names in COLUMNS.values() for name in names)}
    names = dict.fromkeys(name for row in rows for name in row if name not in meant)
    return [name for name in names if name and are_numbers(row.get(name, "") for row in rows)]


def rows_of(
    file: Path, *, vis: str = "", tac: str = "", domain: str = ""
) -> tuple[dict[int, Row], str]:
    """Return the rows of a table of files by their lines, with the project's names of columns and
    the domain and class that the table leaves out; and which other columns name photos and touches,
    and which are not used.

    vis, tac  names of these columns; "": vis and tac, or one each whose words tell
    domain    of all pairs if the table has none; "": the table's folder
    Raises DataError for a table without such columns, or with several whose words tell.
    """
    named = {"vis": vis.lower(), "tac": tac.lower()}
    rows = read_rows(file)
    filled = dict.fromkeys(name for row in rows.values() for name, cell in row.items() if cell)
    header = next(iter(rows.values()), {})
    theirs = {name: [name, *others] for name, others in {**COLUMNS, **TIMES}.items()}
    for half in IMAGES:
        candidates = [name for name in filled if half_of(name) == half and name != BEFORE]
        by_word = [name for name in candidates if _names_files(rows, name, file.parent)]
        theirs[half] = [named[half]] if named[half] else [half] * (half in header) or by_word
        if len(theirs[half]) > 1:
            raise DataError(
                f"'{show(file)}' has the columns {show(', '.join(theirs[half]))}; name one with"
                f" --{half} COLUMN."
            )
    theirs["split"] = ["split", *(n for n in SPLIT_COLUMNS if _names_splits(rows, n))]
    plain = {  # "Object ID" is object_id, and "Start [s]" is start
        re.sub(r"[\s-]+", "_", re.sub(r"\s*[\[(](s|sec|seconds)[\])]$", "", name)): name
        for name in filled
    }
    found = {
        ours: [there for name in names if (there := name if name in filled else plain.get(name))]
        for ours, names in theirs.items()
    }
    for name in ("domain", "material", *IMAGES) if rows else ():
        meant = suggestion(named.get(name) or name, {*filled} - {*found, *TEXTS})
        lost = name in IMAGES and (named[name] or not any(found[half] for half in IMAGES))
        if not found[name] and (meant or lost):
            raise DataError(
                f"'{show(file)}' has no column '{named.get(name) or name}'; its first row has"
                f" {show(', '.join(next(iter(rows.values()))))}, expected vis and tac, and perhaps"
                f" domain, material, {', '.join(TEXTS)}.{meant or _perhaps(rows, filled)}"
            )
    absent = {
        "domain": domain or set_name(file.resolve().parent),
        "material": NO_CLASS,
        "object": "",
    }
    filled_in = {
        line: row
        | {name: row[there[0]] if there else absent.get(name, "") for name, there in found.items()}
        for line, row in rows.items()
    }
    for name in ("object", "domain"):
        for row, text in zip(
            filled_in.values(), one_spelling(r[name] for r in filled_in.values()), strict=True
        ):
            row[name] = text
    columns = [f"{WORDS[m]} of '{found[m][0]}'" for m in IMAGES if found[m] and found[m] != [m]]
    columns += filter(None, [table_note(file)])
    used = {*TEXTS, *OWN, *(name for names in found.values() for name in names[:1])}
    numbers = set(_numbers(list(rows.values())))
    for what, some in (("numbers", filled.keys() & numbers), ("not used", filled.keys() - numbers)):
        if others := [name for name in filled if name and name in some and name not in used]:
            columns.append(f"{what}: {', '.join(others)}")
    return filled_in, ", ".join(columns)


def _perhaps(rows: dict[int, Row], names: Iterable[str]) -> str:
    """Return which columns may be named as photos or touches, for an error."""
    files = [name for name in names if any(is_file_name(row[name]) for row in rows.values())]
    shown = show(", ".join(files))
    return (
        f" Name the columns of photos and touches with --vis and --tac: {shown}." if files else ""
    )


def _names_files(rows: dict[int, Row], name: str, folder: Path) -> bool:
    """Return whether cells of a column are files, perhaps without their suffixes."""
    cells = [cell for row in rows.values() if (cell := row[name])]
    return any(map(is_file_name, cells)) or any(is_file(found_file(folder, c)) for c in cells[:3])


def _names_splits(rows: dict[int, Row], name: str) -> bool:
    cells = {row[name] for row in rows.values() if row.get(name)}
    return all(map(split_of, cells))


def _stands_for_both(rows: list[Row]) -> str:
    """Return the half that stands for both in rows without the other, or "" if such rows are
    left out.
    """
    alone = Counter(half for row in rows for half in IMAGES if row[half] and not row[OTHER[half]])
    ((half, _),) = alone.most_common(1) or (("", 0),)
    return half if alone.total() > RARE * len(rows) else ""


def _why_not(file: Path, number: int, row: Row, pair: Pair, strict: bool) -> str:
    """Return why a row gives no pair, or ""."""
    if pair.alone and not row[pair.alone]:
        return f"it has no {pair.alone} image, and the set is of {WORDS[pair.alone]} alone"
    for name in ("domain", "material", *IMAGES):
        if not row[name] and name != OTHER.get(pair.alone):
            return f"'{name}' is empty"
    if strict and pair.material not in MATERIALS:
        return f"strict: not one of {', '.join(MATERIALS)}"
    for name in IMAGES:
        if not is_file(getattr(pair, name)):
            return f"the {name} image is not there"
    return ""
