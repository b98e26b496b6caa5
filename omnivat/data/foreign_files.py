"""Open an NPZ, Parquet, HDF5 or CSV file as named arrays, without running code in it."""

import csv
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.errors import DataError, OmniVatError, first_line
from omnivat.tables import need

Columns = dict[str, NDArray[Any]]


def read_columns(place: Path) -> Columns:
    """Return the named arrays of a file; its ending gives the format.

    Raises DataError if it is missing, of another kind or unreadable, MissingPackageError if the
    package for it is not installed.
    """
    if not place.is_file():
        raise DataError(f"No file at '{place}'.")
    reader = READERS.get(place.suffix.lower())
    if reader is None:
        raise DataError(f"'{place}' ends in '{place.suffix}'; there are {', '.join(READERS)}.")
    try:
        return reader(place)
    except OmniVatError:
        raise
    except Exception as error:  # each reader has its own errors for damaged files
        raise DataError(f"'{place}' cannot be read ({first_line(error)}); export it again.") from error


def _npz(place: Path) -> Columns:
    if not zipfile.is_zipfile(place):
        raise DataError(f"'{place}' is not an NPZ file; write it with numpy.savez.")
    with np.load(place, allow_pickle=False) as arrays:
        try:
            return {name: arrays[name] for name in arrays.files}
        except ValueError as error:
            raise DataError(
                f"'{place}' holds pickled objects, which are not read; save text as arrays of str."
            ) from error


def _parquet(place: Path) -> Columns:
    parquet = need("pyarrow.parquet", purpose="reading Parquet", install="pyarrow")
    table = parquet.read_table(place)
    found: Columns = {}
    for name, column in zip(table.column_names, table.columns, strict=True):
        rows = column.to_pylist()
        if "list" not in str(column.type):
            rows = ["" if value is None else value for value in rows]
        elif len({len(row or ()) for row in rows}) > 1:
            raise DataError(f"'{place}' has lists of differing lengths in '{name}'.")
        found[name] = np.array(rows)
    return found


def _hdf5(place: Path) -> Columns:
    h5py = need("h5py", purpose="reading HDF5")
    with h5py.File(place, "r") as file:
        return {
            name: dataset.asstr()[()].astype(str) if dataset.dtype.kind == "O" else dataset[()]
            for name, dataset in file.items()
            if hasattr(dataset, "dtype")
        }


def _csv(place: Path) -> Columns:
    with place.open(newline="", encoding="utf-8-sig") as handle:
        rows = list(csv.reader(handle))
    if len(rows) < 2:
        raise DataError(f"'{place}' has no rows below its header.")
    names, body = rows[0], rows[1:]
    short = next((i for i, row in enumerate(body, start=2) if len(row) != len(names)), None)
    if short is not None:
        raise DataError(f"'{place}' has {len(body[short - 2])} cells in line {short}, not {len(names)}.")
    return {name: np.array(column) for name, column in zip(names, zip(*body, strict=True), strict=True)}


READERS = {".npz": _npz, ".parquet": _parquet, ".h5": _hdf5, ".hdf5": _hdf5, ".csv": _csv}
