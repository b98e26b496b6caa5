"""Tell by what lies in a folder which reader it needs."""

from pathlib import Path

from omnivat.data.readers.names import is_file, show
from omnivat.errors import DataError


def recognise(source: Path) -> str:
    """Return the name of the reader for `source`, a folder or a CSV file.

    Raises DataError for a file that is not a CSV.
    """
    if is_file(source):
        if source.suffix.lower() == ".csv":
            return "csv"
        raise DataError(
            f"'{show(source)}' is a file, but pairs come from a folder or a CSV. "
            "Give the folder it lies in, or a .csv with the columns vis, tac, domain, material."
        )
    if is_file(source / "pairs.csv"):
        return "csv"
    return "folder"
