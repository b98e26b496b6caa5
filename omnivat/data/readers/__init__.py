"""Readers of pairs: one file a data set, one table, one door."""

from inspect import Parameter, signature
from pathlib import Path
from typing import Any

from omnivat.data.pairs import PairSet
from omnivat.data.readers.names import exists, show
from omnivat.data.readers.recognise import recognise
from omnivat.errors import DataError, SettingsError
from omnivat.tables import load, suggestion

READERS = {
    "folder": "omnivat.data.readers.folder:read",
    "csv": "omnivat.data.readers.table:read",
    "touch_and_go": "omnivat.data.readers.touch_and_go:read",
    "objectfolder_real": "omnivat.data.readers.objectfolder_real:read",
    "objectfolder_2": "omnivat.data.readers.objectfolder_2:read",
    "tacquad": "omnivat.data.readers.tacquad:read",
}


def read_pairs(
    source: Path | str, *, reader: str = "auto", strict: bool = False, seed: int = 0, **options: Any
) -> PairSet:
    """Return the pairs of a data set on disk, with what was left out and why.

    source   a folder, or a CSV file with a row for each pair
    reader   a name in READERS; "auto" tells from what lies in the folder
    strict   only the five materials under their own names: no iron as steel, no other classes
    seed     of the balanced subsampling, where the reader has one
    options  settings of that reader alone, such as by_folder for Touch-and-Go

    Raises DataError when there is nothing at `source`, it is of another layout, or it holds no
    pairs; SettingsError for an option that the reader does not have.
    """
    path = Path(source)
    if not exists(path):
        raise DataError(f"There is no folder or file at '{show(path)}'. Check the path.")
    name = recognise(path) if reader == "auto" else reader
    read = load(READERS, name, kind="reader")
    own = [
        parameter.name
        for parameter in signature(read).parameters.values()
        if parameter.kind is Parameter.KEYWORD_ONLY and parameter.name not in ("strict", "seed")
    ]
    for option in options:
        if option not in own:
            known = f"it has {', '.join(own)}" if own else "it has none"
            raise SettingsError(
                f"The reader '{name}' has no option '{option}'; {known}.{suggestion(option, own)}"
            )
    found: PairSet = read(path, strict=strict, seed=seed, **options)
    return found
