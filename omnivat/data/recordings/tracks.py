"""Recordings of one contact: their tracks and labels; pictures of a track, from a video or a
Parquet file.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.data.images import check_size, read_image
from omnivat.data.readers.files import show
from omnivat.kit.errors import DataError, first_line
from omnivat.kit.files import require_regular
from omnivat.kit.tables import need

if TYPE_CHECKING:
    from PIL import Image

NEAR = 0.25  # of a frame: a picture so little later counts as shown


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
    """One recording of one contact, and its labels.

    read  gives its tracks by modality and its seconds (None: the video's), or raises DataError
    """

    name: str
    read: Callable[[], tuple[Mapping[str, Track], float | None]]
    domain: str
    material: str
    object: str
    split: str = ""


def pictures(track: Track, times: Sequence[float]) -> Iterator["Image.Image"]:
    """Yield the picture of a track at each of the rising times; raises DataError if one is
    missing.
    """
    return _stored(track, times) if track.column else _filmed(track, times)


def _stored(track: Track, times: Sequence[float]) -> Iterator["Image.Image"]:
    rows = parquet_rows(track.file, [track.column], [("episode_index", "=", track.episode)])
    for moment in times:
        k = min(int(moment * track.fps + NEAR), len(rows) - 1)
        cell = rows[k].get(track.column) if rows else None
        content = cell.get("bytes") if isinstance(cell, dict) else None
        if not isinstance(content, bytes) or not content:  # a text would be read as a path
            raise DataError(
                f"'{show(track.file)}' has no picture '{track.column}' at {moment:.2f} s."
            )
        yield read_image(content, f"{track.file.name}, row {k}")


def _opened(file: Path) -> tuple[Any, Any]:
    av = need("av", purpose="reading videos")
    require_regular(file, show(file))
    try:
        container = av.open(str(file))
        stream = container.streams.video[0]
        if stream.width:  # 0 if the container does not state it
            check_size(stream.width, stream.height, show(file))
        return container, stream
    except (av.error.FFmpegError, OSError, IndexError) as error:
        raise DataError(
            f"'{show(file)}' is no video that can be read; export it as MP4."
        ) from error


def extent(track: Track) -> tuple[float, float]:
    """Return the seconds of a track's file (0 if stored in a table) and its pictures a second."""
    if track.fps:
        return 0.0, track.fps
    container, stream = _opened(track.file)
    with container:
        whole = (container.duration or 0) / 1e6
        seconds = stream.duration * stream.time_base if stream.duration else whole
        return float(seconds), float(stream.average_rate or 30)


def _filmed(track: Track, times: Sequence[float]) -> Iterator["Image.Image"]:
    container, stream = _opened(track.file)
    waiting = [track.start + moment for moment in times]
    first = float((stream.start_time or 0) * stream.time_base)
    step, last, shown = 1 / float(stream.average_rate or 30), None, 0.0
    with container:
        try:
            container.seek(int((waiting[0] + first) / stream.time_base), stream=stream)
            for frame in container.decode(stream):
                check_size(frame.width, frame.height, show(track.file))  # it may change
                now = (frame.time or 0.0) - first
                while waiting and last is not None and now > waiting[0] + NEAR * step:
                    yield last.to_image()  # the one shown at that moment
                    waiting.pop(0)
                if not waiting:
                    return
                last, shown = frame, now
        except DataError:
            raise
        except Exception as error:  # PyAV has many kinds for damaged files
            raise DataError(f"'{show(track.file)}' is damaged near {waiting[0]:.2f} s.") from error
        while waiting and last is not None and waiting[0] <= shown + 1.5 * step:
            yield last.to_image()
            waiting.pop(0)
    if waiting:
        raise DataError(f"'{show(track.file)}' ends before {waiting[0]:.2f} s.")


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
