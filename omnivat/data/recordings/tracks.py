"""Recordings of one contact, their labels, and their tracks: pictures in time, of a video or of
frames that a file holds.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from omnivat.data.images import read_image
from omnivat.data.parquet import parquet_cells
from omnivat.data.readers.files import show
from omnivat.data.recordings.films import NEAR, read_film, step_of
from omnivat.kit.errors import DataError
from omnivat.kit.tables import need

if TYPE_CHECKING:
    from PIL import Image


class Track(Protocol):
    """Pictures in time from one camera or sensor."""

    @property
    def file(self) -> Path:
        """Where they are."""

    def shown(self, length: float | None) -> tuple[NDArray[np.float64], float]:
        """Return when each picture appears, in seconds from the start, and when the last one ends;
        `length` seconds of them, or all.
        """

    def pictures(self, moments: Sequence[float]) -> "Iterator[Image.Image]":
        """Yield the picture that is shown at each of the rising moments, in seconds from the
        start; raises DataError if one is missing.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class Clip:
    """One recording of one contact, and its labels.

    read     gives its tracks by modality and its seconds (None: all), or raises DataError
    cameras  which camera is the photo and which the touch, for people
    frames   pairs of it at most; 0: as many as are wanted of each recording
    """

    name: str
    read: Callable[[], tuple[Mapping[str, Track], float | None]]
    domain: str
    material: str
    object: str
    split: str = ""
    cameras: str = ""
    frames: int = 0


@dataclass(frozen=True, kw_only=True)
class Film:
    """A video. What its container states about its length may be wrong, so its pictures tell.

    fps  pictures a second, of a data set that states them and cuts episodes from long films
    """

    file: Path
    start: float = 0.0  # seconds
    fps: float = 0.0

    def shown(self, length: float | None) -> tuple[NDArray[np.float64], float]:
        """As `Track`."""
        if self.fps and length is not None:
            return np.arange(int(length * self.fps + 0.5)) / self.fps, length
        times, end, _ = self._times
        end = end - self.start if length is None else length
        return _within(times - self.start, end), end

    @cached_property
    def _times(self) -> tuple[NDArray[np.float64], float, float]:
        """When each picture appears, when the last one ends, and the seconds between two."""
        ((about, content),) = self._read()
        return np.frombuffer(content), about["end"], about["step"]

    def pictures(self, moments: Sequence[float]) -> "Iterator[Image.Image]":
        """As `Track`."""
        from PIL import Image

        waiting = [self.start + moment for moment in moments]
        _, end, step = (None, None, 1 / self.fps) if self.fps else self._times
        for about, pixels in self._read(waiting=waiting, step=step, end=end):
            yield Image.frombytes("RGB", about["size"], pixels)

    def _read(self, **of: Any) -> Iterator[tuple[Any, bytes]]:
        need("av", purpose="reading videos")
        return read_film.read(self.file, "export it as MP4", name=show(self.file), **of)


@dataclass(frozen=True, slots=True, kw_only=True)
class Frames:
    """Pictures that a file holds one by one.

    times    seconds at which they appear, rising
    picture  gives one by its number, or raises DataError
    """

    file: Path
    times: Sequence[float]
    picture: "Callable[[int], Image.Image]" = field(repr=False)

    def shown(self, length: float | None) -> tuple[NDArray[np.float64], float]:
        """As `Track`."""
        times = np.array(self.times, float)
        if length is None:
            length = float(times[-1] + step_of(times)) if len(times) else 0.0
        return _within(times, length), length

    def pictures(self, moments: Sequence[float]) -> "Iterator[Image.Image]":
        """As `Track`."""
        near = NEAR * step_of(np.array(self.times, float))
        for moment in moments:
            number = int(np.searchsorted(self.times, moment + near, side="right")) - 1
            if number < 0:
                raise DataError(f"'{show(self.file)}' has no picture at {moment:.2f} s.")
            yield self.picture(number)


def _within(times: NDArray[np.float64], end: float) -> NDArray[np.float64]:
    """Return the times from the start to `end`, beginning with the picture that is shown then."""
    held = times[times <= 0][-1:] * 0
    return np.concatenate([held, times[(times > 0) & (times < end)]])


def stored(file: Path, column: str, episode: int, fps: float) -> Frames:
    """Return the pictures of an episode in a column of a Parquet file."""
    contents = parquet_cells(file, column, episode)

    def picture(number: int) -> "Image.Image":
        if not contents[number]:
            raise DataError(f"'{show(file)}' has no picture '{column}' in row {number}.")
        return read_image(contents[number], f"{file.name}, row {number}")

    return Frames(file=file, times=[k / fps for k in range(len(contents))], picture=picture)
