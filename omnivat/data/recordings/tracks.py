"""Recordings of one contact, their labels, and their tracks: pictures in time, of a video or of
frames that a file holds.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from omnivat.data.images import UPRIGHT, check_size, read_image
from omnivat.data.readers.files import show
from omnivat.kit.errors import DataError, first_line
from omnivat.kit.files import require_regular
from omnivat.kit.tables import need

if TYPE_CHECKING:
    from PIL import Image

EARLIER = 10.0  # seconds before a film's start: a transport stream is sought by its bytes
NEAR = 0.25  # of a frame: a picture so little later counts as shown
EXIF_OF = {  # signs of a film's display matrix (x from x, y from x, x from y, y from y)
    (-1, 0, 0, 1): 2,
    (-1, 0, 0, -1): 3,
    (1, 0, 0, -1): 4,
    (0, 1, 1, 0): 5,
    (0, 1, -1, 0): 6,
    (0, -1, -1, 0): 7,
    (0, -1, 1, 0): 8,
}


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
        times, end = self._times
        end = end - self.start if length is None else length
        return _within(times - self.start, end), end

    @cached_property
    def _times(self) -> tuple[NDArray[np.float64], float]:
        """When each picture appears, and when the last one ends."""
        container, stream = _opened(self.file)
        with container, _explained(self.file, "its end"):
            found = sorted(
                (packet.dts if packet.pts is None else packet.pts, packet.duration or 0)
                for packet in container.demux(stream)
                if packet.size and not packet.is_discard
            )
            # a closed container has freed what its stream reads
            unit, origin, other = float(stream.time_base), _origin(stream), _rate_step(stream)
        if not found:
            raise DataError(f"'{show(self.file)}' has no pictures; export it as MP4.")
        times = np.array([stamp for stamp, _ in found]) * unit - origin
        return times, float(times[-1] + max(found[-1][1] * unit, _step(times, other)))

    def pictures(self, moments: Sequence[float]) -> "Iterator[Image.Image]":
        """As `Track`."""
        container, stream = _opened(self.file)
        waiting = [self.start + moment for moment in moments]
        step = 1 / self.fps if self.fps else _step(self._times[0], _rate_step(stream))
        last, shown = None, 0.0
        with container, _explained(self.file, f"{waiting[0]:.2f} s"):
            for frame in _decoded(container, stream, waiting[0] + NEAR * step):
                check_size(frame.width, frame.height, show(self.file))  # it may change
                shown = (frame.time or 0.0) - _origin(stream)
                while waiting and last is not None and shown > waiting[0] + NEAR * step:
                    yield _upright(last)  # the one shown at that moment
                    waiting.pop(0)
                if not waiting:
                    return
                last = frame
            end = shown + 1.5 * step if self.fps else self._times[1]
            while waiting and last is not None and waiting[0] <= end:
                yield _upright(last)
                waiting.pop(0)
        if waiting:
            raise DataError(f"'{show(self.file)}' ends before {waiting[0]:.2f} s.")


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
            length = float(times[-1] + _step(times)) if len(times) else 0.0
        return _within(times, length), length

    def pictures(self, moments: Sequence[float]) -> "Iterator[Image.Image]":
        """As `Track`."""
        near = NEAR * _step(np.array(self.times, float))
        for moment in moments:
            number = int(np.searchsorted(self.times, moment + near, side="right")) - 1
            if number < 0:
                raise DataError(f"'{show(self.file)}' has no picture at {moment:.2f} s.")
            yield self.picture(number)


def _within(times: NDArray[np.float64], end: float) -> NDArray[np.float64]:
    """Return the times from the start to `end`, beginning with the picture that is shown then."""
    held = times[times <= 0][-1:] * 0
    return np.concatenate([held, times[(times > 0) & (times < end)]])


def _step(times: NDArray[np.float64], alone: float = 1 / 30) -> float:
    """Return the seconds between two pictures; `alone` for a single one."""
    return float(np.median(np.diff(times))) if len(times) > 1 else alone


def _rate_step(stream: Any) -> float:
    return 1 / float(stream.average_rate or 30)


def _opened(file: Path) -> tuple[Any, Any]:
    av = need("av", purpose="reading videos")
    require_regular(file, show(file))
    try:
        container = av.open(str(file), metadata_errors="replace")
        stream = container.streams.video[0]
        width, height = stream.width, stream.height
    except Exception as error:  # PyAV has many kinds for damaged files
        raise DataError(
            f"'{show(file)}' is no video that can be read; export it as MP4."
        ) from error
    if width:  # 0 if the container does not state it
        check_size(width, height, show(file))
    return container, stream


def _origin(stream: Any) -> float:
    return float((stream.start_time or 0) * stream.time_base)


@contextmanager
def _explained(file: Path, where: str) -> Iterator[None]:
    try:
        yield
    except DataError:
        raise
    except Exception as error:  # PyAV has many kinds for damaged files
        raise DataError(f"'{show(file)}' is damaged near {where}.") from error


def _decoded(container: Any, stream: Any, moment: float) -> Iterator[Any]:
    """Yield frames from one that is shown at `moment` or earlier; a film without an index is
    decoded from its start, which some are sought before.
    """
    for seconds in (moment, -EARLIER):
        container.seek(int((seconds + _origin(stream)) / stream.time_base), stream=stream)
        frames = container.decode(stream)
        first = next(frames, None)
        if first is not None and ((first.time or 0.0) - _origin(stream) <= moment or seconds < 0):
            yield first
            yield from frames
            return


def _upright(frame: Any) -> "Image.Image":
    """Return a frame as its film says that it is to be shown: turned or mirrored."""
    image: Image.Image = frame.to_image()
    matrix = frame.side_data.get("DISPLAYMATRIX")
    if matrix is None:
        return image
    a, b, _, c, d = np.sign(np.frombuffer(bytes(matrix), "<i4")[:5]).tolist()
    turn = UPRIGHT.get(EXIF_OF.get((a, b, c, d), 1))
    return image if turn is None else image.transpose(turn)


def stored(file: Path, column: str, episode: int, fps: float) -> Frames:
    """Return the pictures of an episode in a column of a Parquet file."""
    rows = parquet_rows(file, [column], [("episode_index", "=", episode)])

    def picture(number: int) -> "Image.Image":
        cell = rows[number].get(column)
        content = cell.get("bytes") if isinstance(cell, dict) else None
        if not isinstance(content, bytes) or not content:  # a text would be read as a path
            raise DataError(f"'{show(file)}' has no picture '{column}' in row {number}.")
        return read_image(content, f"{file.name}, row {number}")

    return Frames(file=file, times=[k / fps for k in range(len(rows))], picture=picture)


def parquet_rows(
    file: Path, columns: list[str] | None = None, filters: Any = None
) -> list[dict[str, Any]]:
    """Return rows of a Parquet file; raises DataError if it cannot be read."""
    require_regular(file, show(file))
    parquet = need("pyarrow.parquet", purpose="reading LeRobot data sets", install="pyarrow")
    try:
        table = parquet.read_table(file, columns=columns, filters=filters)
    except Exception as error:  # pyarrow has its own kinds for damaged files
        raise DataError(f"'{show(file)}' cannot be read ({first_line(error)}).") from error
    return list(table.to_pylist())
