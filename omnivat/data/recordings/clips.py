"""A recording of one contact: its tracks of pictures, and its labels."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

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
