"""Pairs whose pictures lie in one file, a row for each: Parquet with pictures as the package
`datasets` writes it, and arrays of pictures in NPZ, HDF5 or safetensors.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from omnivat.data.class_labels import class_names, labelled_rows
from omnivat.data.columns import READERS, Columns, columns_of
from omnivat.data.foreign import texts_in
from omnivat.data.materials import NO_CLASS, class_key
from omnivat.data.naming import COLUMNS, cameras_among, checked_split, set_name, split_of
from omnivat.data.readers.files import TABLES, show
from omnivat.data.recordings.tracks import Clip, Frames, Track
from omnivat.kit.errors import DataError

if TYPE_CHECKING:
    from PIL import Image

STORED = tuple(ending for ending in READERS if ending not in TABLES)
LABELS = ("domain", "material", "object", "split")


def stored_files(source: Path) -> list[Path]:
    """Return the file, or the Parquet files of a folder, in order; [] for anything else."""
    if source.is_dir():
        return sorted(f for f in source.rglob("*.parquet") if not f.name.startswith("."))
    return [source] if source.suffix.lower() in STORED else []


def stored_clips(
    source: Path,
    *,
    vis: str,
    tac: Sequence[str],
    domain: str,
    classes: Sequence[str],
    columns: Mapping[str, str],
) -> list[Clip]:
    """Return a pair for each row of a file, or of the Parquet files of a folder, with pictures.

    A folder above a file, but for "data" and splits, names the domain, and the file's name or its
    folder may tell the split.

    vis, tac  names of the columns or arrays of photos and touches; "" and (): by their words
    domain    of all pairs without one; "": the folder's name
    classes   names of numbered classes
    columns   name here -> name in the file, if they differ; "": no column
    Raises DataError if a file has no pictures, or if its columns cannot be told.
    """
    root = source if source.is_dir() else source.parent
    clips: list[Clip] = []
    for file in stored_files(source):
        table = columns_of(file)
        found = {name: one for name in table.names if (one := table.pictures_of(name))}
        if not found:
            raise DataError(
                f"'{show(file)}' holds no pictures; of vectors, name their encoder with --encoder"
                " NAME."
            )
        photo, touches, places = cameras_among([*found], vis, tac, f"'{show(file)}'")
        count = min(rows for rows, _ in found.values())
        texts = _labels(table, count, classes, columns)
        told = (file.stem.partition("-")[0], file.parent.name if file.parent != root else "")
        split = next(filter(None, map(split_of, told)), "")
        above = [p for p in file.relative_to(root).parent.parts if p != "data" and not split_of(p)]
        clips += [
            Clip(
                read=partial(_read, file, {h: found[n][1] for h, n in named.items() if n}, k),
                name=f"{file.stem} {k:06d}",
                domain=texts["domain"][k]
                or domain
                or " ".join(filter(None, (*above, place)))
                or set_name(root.resolve()),
                material=class_key(texts["material"][k]) or NO_CLASS,
                object=texts["object"][k],
                split=checked_split(texts["split"][k], f"'{show(file)}', row {k}") or split,
                cameras=f"photo {photo or 'none'}, touch {touch or 'none'}",
                frames=1,
            )
            for touch, place in zip(touches, places, strict=True)
            for named in [{"vis": photo, "tac": touch}]
            for k in range(count)
        ]
    return clips


def _labels(
    table: Columns, count: int, classes: Sequence[str], columns: Mapping[str, str]
) -> dict[str, list[str]]:
    """Return the texts of each row; a class without a name is ""."""
    texts = {}
    for name in LABELS:
        theirs = (columns[name],) if name in columns else (name, *COLUMNS.get(name, ()))
        arrays = (table.get(one) for one in theirs if table.path(one))
        array = next((one for one in arrays if one is not None), None)
        if array is None and columns.get(name):
            raise DataError(
                f"'{table.place}' has no column '{columns[name]}'; it has {', '.join(table.names)}."
            )
        texts[name] = [""] * count if array is None else texts_in(array, name, count, table.place)
    kept = labelled_rows(texts["material"])
    named = class_names([texts["material"][k] for k in kept], classes or None, table.place)
    by_row = dict(zip(kept, named, strict=True))
    return texts | {"material": [by_row.get(k, "") for k in range(count)]}


def _read(
    file: Path, halves: Mapping[str, "Callable[[int], Image.Image]"], row: int
) -> tuple[dict[str, Track], None]:
    return {half: still(file, partial(one, row)) for half, one in halves.items()}, None


def still(file: Path, picture: "Callable[[], Image.Image]") -> Track:
    """Return a single picture as a track."""
    return Frames(file=file, times=[0.0], picture=lambda _: picture())
