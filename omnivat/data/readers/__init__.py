"""Readers of pairs: one file for each data set, one table, one entry point."""

import os
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from inspect import Parameter, signature
from pathlib import Path
from typing import Any

from omnivat.data.domains import is_simulated, require_domain_names
from omnivat.data.naming import TACTILE, VIDEOS
from omnivat.data.pairs import PairSet
from omnivat.data.readers.files import show
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.files import path_of
from omnivat.kit.tables import load, require_choice, suggestion

ARCHIVES = (".zip", ".tar", ".gz", ".tgz", ".bz2", ".xz", ".7z", ".rar")
OF_PROGRAMS = (".npz", ".parquet", ".h5", ".hdf5", *TACTILE)
# Tried in this order if no reader is named. A reader is a module with `read` and `recognises`.
READERS = {
    "csv": "omnivat.data.readers.table:read",
    "tacquad": "omnivat.data.readers.tacquad:read",
    "objectfolder_2": "omnivat.data.readers.objectfolder_2:read",
    "objectfolder_real": "omnivat.data.readers.objectfolder_real:read",
    "touch_and_go": "omnivat.data.readers.touch_and_go:read",
    "folder": "omnivat.data.readers.folder:read",
}


def recognised(source: Path) -> str:
    """Return the name of the first reader that recognises `source`, a folder or a CSV file.

    Raises DataError for a file that is not a CSV.
    """
    for name, target in READERS.items():
        if import_module(target.split(":")[0]).recognises(source):
            return name
    kind, place = source.suffix.lower(), f"'{show(source)}'"
    if kind in VIDEOS:
        columns = "vis or tac (files), material and object"
        raise DataError(f"{place} is a film; import a table that names it, with columns {columns}.")
    if kind in ARCHIVES:
        raise DataError(f"{place} is an archive; unpack it, and give the folder.")
    if kind in OF_PROGRAMS:
        make = f"`python -m omnivat import {show(source)} --out PAIRS`"
        raise DataError(
            f"{place} is a file of another program; make a folder of pairs first: {make}."
        )
    raise DataError(
        f"{place} is a file, but pairs come from a folder or a CSV. Give the folder it lies in, or"
        " a .csv with the columns vis, tac, domain, material."
    )


def read_pairs(
    source: Path | str, *, reader: str = "auto", strict: bool = False, seed: int = 0, **options: Any
) -> PairSet:
    """Return the pairs of a data set on disk, and the skipped items with reasons.

    source   a folder, or a CSV file with a row for each pair
    reader   a name in READERS; "auto" recognises the layout
    strict   only the five materials under their own names: no iron as steel, no other classes
    seed     of the balanced subsampling, if the reader has one
    options  settings of that reader, such as by_folder for Touch-and-Go; a truth value may be the
             text "true" or "false", from a command line

    Raises DataError if `source` is missing, has another layout, no pairs, or a domain called "all";
    SettingsError for an option that the reader lacks.

    >>> from omnivat.head.heads import EXAMPLES
    >>> found = read_pairs(EXAMPLES / "pairs")
    >>> pair = found.pairs[0]
    >>> pair.domain, pair.material, pair.vis.suffix, pair.tac.suffix
    ('OF 2.0 A-sim', 'ceramic', '.jpg', '.jpg')
    """
    path = path_of(source)
    if not os.path.exists(path):  # also for a name too long, or a looping link
        raise DataError(f"There is no folder or file at '{show(path)}'. Check the path.")
    name = recognised(path) if reader == "auto" else reader
    read = load(READERS, name, kind="reader")
    found: PairSet = read(path, strict=strict, seed=seed, **_checked(name, read, options))
    require_domain_names(found.domains())
    simulated = found.simulated or any(map(is_simulated, found.domains()))
    return replace(found, simulated=simulated)


def _checked(name: str, read: Callable[..., PairSet], options: dict[str, Any]) -> dict[str, Any]:
    """Return the options, with the texts "true" and "false" as truth values."""
    own = {
        parameter.name: parameter.default
        for parameter in signature(read).parameters.values()
        if parameter.kind is Parameter.KEYWORD_ONLY and parameter.name not in ("strict", "seed")
    }
    checked = dict(options)
    for option, value in options.items():
        if option not in own:
            known = f"it has {', '.join(own)}" if own else "it has none"
            raise SettingsError(
                f"The reader '{name}' has no option '{option}'; {known}.{suggestion(option, own)}"
            )
        if isinstance(own[option], bool) and not isinstance(value, bool):
            require_choice(option, str(value).lower(), ("true", "false"))
            checked[option] = str(value).lower() == "true"
    return checked
