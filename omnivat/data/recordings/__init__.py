"""Pairs of pictures from recordings: LeRobot data sets with tactile images, and videos with a
table of labels.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from omnivat.data.materials import NO_CLASS, class_key
from omnivat.data.readers.files import number_in, read_rows
from omnivat.data.recordings.lerobot import INFO, LeRobot
from omnivat.data.recordings.tracks import Clip, Track
from omnivat.data.recordings.writing import write_pairs
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.stages import IMAGES

__all__ = ["clips_of", "is_recording", "write_pairs"]

TABLE = "videos.csv"  # of a folder of videos
DAY = 86_400.0  # seconds; no recording of a contact is longer
VIDEOS = (".mp4", ".mov", ".avi", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg")


def is_recording(source: Path) -> bool:
    """True for a LeRobot data set, a folder with a videos.csv, or a CSV that names videos."""
    if source.is_dir():
        return (source / INFO).is_file() or (source / TABLE).is_file()
    if source.suffix.lower() != ".csv" or not source.is_file():
        return False
    with source.open(encoding="utf-8-sig", errors="replace") as lines:
        first = [next(lines, "") for _ in range(2)][1].lower()
    return any(ending in first for ending in VIDEOS)


def clips_of(
    source: Path,
    *,
    vis: str = "",
    tac: Sequence[str] = (),
    domain: str = "",
    labels: Path | None = None,
) -> list[Clip]:
    """Return the recordings in `source`.

    vis, tac  LeRobot: names of cameras; "" and () choose by name
    domain    of all pairs; "": the name of the data set, or of the tactile camera if there are
              several
    labels    LeRobot: a CSV with the columns episode and material, perhaps domain, object, split

    Raises DataError for another layout, or if the cameras cannot be told.
    """
    if source.is_dir() and (source / INFO).is_file():
        return LeRobot(source).clips(vis, tac, domain, labels)
    if vis or tac or labels:
        raise SettingsError(
            "--vis, --tac and --labels are for LeRobot; here the table has names and labels."
        )
    return _videos(source / TABLE if source.is_dir() else source, domain)


def _videos(file: Path, domain: str) -> list[Clip]:
    """Return the recordings of a table: vis and tac name videos; start and end are seconds."""
    return [
        Clip(
            read=partial(_filmed, file.parent, row),
            name=f"row {number}",
            domain=row.get("domain") or domain or file.absolute().parent.name,
            material=class_key(row["material"]) or NO_CLASS,
            object=row.get("object") or f"row {number}",
            split=row.get("split", ""),
        )
        for number, row in read_rows(file, ("material",)).items()
    ]


def _filmed(folder: Path, row: dict[str, str]) -> tuple[dict[str, Track], float | None]:
    """Return the tracks of a row, and its length in seconds; None for the video's."""
    given = [name for name in ("start", "end", "tac_delay") if row.get(name)]
    seconds = {name: number_in(row[name], -DAY, DAY, name) for name in given}
    start, delay = seconds.get("start", 0.0), {"vis": 0.0, "tac": seconds.get("tac_delay", 0.0)}
    names = {half: row[half] for half in IMAGES if row.get(half)}
    if not names:
        raise DataError("It names no video; name one under vis or tac.")
    tracks = {
        half: Track(file=folder / name, start=start + delay[half]) for half, name in names.items()
    }
    return tracks, seconds["end"] - start if "end" in seconds else None
