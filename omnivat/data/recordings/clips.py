"""A recording of one contact: its tracks of pictures, and its labels."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from omnivat.data.readers.lists import read_cells
from omnivat.data.readers.names import show
from omnivat.errors import DataError

HALVES = ("vis", "tac")


@dataclass(frozen=True, slots=True, kw_only=True)
class Track:
    """Pictures in time: a video, or a column of a Parquet file."""

    file: Path
    start: float = 0.0  # seconds
    column: str = ""
    episode: int = 0
    fps: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Clip:
    """One recording of one contact: its tracks by modality, and its labels."""

    name: str
    tracks: Mapping[str, Track]
    length: float | None  # seconds; None: the video's
    domain: str
    material: str
    object: str
    split: str = ""


def labelled_rows(file: Path, needed: Sequence[str]) -> list[dict[str, str]]:
    """Return the rows of a CSV by the names in its first row."""
    header, *cells = read_cells(file) or [[]]
    header = [name.lower() for name in header]
    if missing := [name for name in needed if name not in header]:
        raise DataError(f"'{show(file)}' has no column '{missing[0]}'; expected {', '.join(needed)}.")
    return [dict(zip(header, row, strict=False)) for row in cells]
