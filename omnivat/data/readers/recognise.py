"""Tell by what lies in a folder which reader it needs."""

from pathlib import Path

from omnivat.data.readers.names import folders_in, is_file, show
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
    if is_file(source / "contact_indoor.csv") or is_file(source / "contact_outdoor.csv"):
        return "tacquad"
    if is_file(source / "label.json") and (source / "touch").is_dir():
        return "objectfolder_2"
    inside = folders_in(source)
    if any((folder / "tactile_data").is_dir() for folder in inside):
        return "objectfolder_real"
    clips = folders_in(source / "dataset") or inside
    if any((clip / "gelsight_frame").is_dir() for clip in clips):
        return "touch_and_go"
    return "folder"
