"""Pictures of films, decoded in a limited process."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from omnivat.data.images import UPRIGHT, check_size
from omnivat.kit.errors import DataError
from omnivat.kit.limited import Limited

EARLIER = 10.0  # seconds before a film's start: a transport stream is sought by its bytes
NEAR = 0.25  # of a frame: a picture so little later counts as shown
# FFmpeg's names; without its lists, which lead to other files
CONTAINERS = "mov,matroska,avi,mpegts,mpeg,mpegvideo,m4v,flv,asf,ogg,mxf,ivf,dv,h264,hevc,mjpeg"
BEAT = 8  # frames after which the limits are renewed: a long film may take long
EXIF_OF = {  # signs of a film's display matrix (x from x, y from x, x from y, y from y)
    (-1, 0, 0, 1): 2,
    (-1, 0, 0, -1): 3,
    (1, 0, 0, -1): 4,
    (0, 1, 1, 0): 5,
    (0, 1, -1, 0): 6,
    (0, -1, -1, 0): 7,
    (0, -1, 1, 0): 8,
}


def decoded(
    _: bytes,
    *,
    file: str,
    name: str,
    waiting: Sequence[float] | None = None,
    step: float = 0.0,
    end: float | None = None,
) -> Iterator[tuple[dict[str, Any] | None, bytes]]:
    """Yield when each picture appears, or the pictures that are shown at rising moments. Runs in
    the limited process.

    waiting  seconds from the film's start; None: the times are wanted
    step     seconds between two pictures
    end      seconds at which the last one ends; None: its container may hold more
    """
    import av

    try:
        how = {"format_whitelist": CONTAINERS}
        container = av.open(file, metadata_errors="replace", options=how)
        stream = container.streams.video[0]
        width, height = stream.width, stream.height
    except Exception as error:  # PyAV has many kinds for damaged files
        raise DataError(f"'{name}' is no video that can be read; export it as MP4.") from error
    with container:
        if width:  # 0 if the container does not state it
            check_size(width, height, name)
        if waiting is None:
            yield _times(container, stream, name)
        else:
            yield from _shown(container, stream, name, [*waiting], step, end)


def _times(container: Any, stream: Any, name: str) -> tuple[dict[str, Any], bytes]:
    with _explained(name, "its end"):
        found = sorted(
            (packet.dts if packet.pts is None else packet.pts, packet.duration or 0)
            for packet in container.demux(stream)
            if packet.size and not packet.is_discard
        )
    if not found:
        raise DataError(f"'{name}' has no pictures; export it as MP4.")
    unit = float(stream.time_base)
    times = np.array([stamp for stamp, _ in found]) * unit - _origin(stream)
    step = step_of(times, 1 / float(stream.average_rate or 30))
    end = float(times[-1] + max(found[-1][1] * unit, step))
    return {"end": end, "step": step}, times.tobytes()


def step_of(times: NDArray[np.float64], alone: float = 1 / 30) -> float:
    """Return the seconds between two pictures; `alone` for a single one."""
    return float(np.median(np.diff(times))) if len(times) > 1 else alone


def _shown(
    container: Any, stream: Any, name: str, waiting: list[float], step: float, end: float | None
) -> Iterator[tuple[dict[str, Any] | None, bytes]]:
    last, shown = None, 0.0
    with _explained(name, f"{waiting[0]:.2f} s"):
        for number, frame in enumerate(_decoded(container, stream, waiting[0] + NEAR * step)):
            check_size(frame.width, frame.height, name)  # it may change
            shown = (frame.time or 0.0) - _origin(stream)
            while waiting and last is not None and shown > waiting[0] + NEAR * step:
                yield _upright(last)  # the one shown at that moment
                waiting.pop(0)
            if not waiting:
                return
            last = frame
            if number % BEAT == 0:
                yield None, b""
        end = shown + 1.5 * step if end is None else end
        while waiting and last is not None and waiting[0] <= end:
            yield _upright(last)
            waiting.pop(0)
    if waiting:
        raise DataError(f"'{name}' ends before {waiting[0]:.2f} s.")


def _origin(stream: Any) -> float:
    return float((stream.start_time or 0) * stream.time_base)


@contextmanager
def _explained(name: str, where: str) -> Iterator[None]:
    try:
        yield
    except (DataError, MemoryError):
        raise
    except Exception as error:  # PyAV has many kinds for damaged files
        raise DataError(f"'{name}' is damaged near {where}.") from error


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


def _upright(frame: Any) -> tuple[dict[str, Any], bytes]:
    """Return a frame as its film says that it is to be shown: turned or mirrored."""
    pixels = frame.to_ndarray(format="rgb24")  # many times faster than to_image
    if (matrix := frame.side_data.get("DISPLAYMATRIX")) is not None:
        a, b, _, c, d = np.sign(np.frombuffer(bytes(matrix), "<i4")[:5]).tolist()
        if (turn := UPRIGHT.get(EXIF_OF.get((a, b, c, d), 1))) is not None:
            pixels = np.asarray(Image.fromarray(pixels).transpose(turn))
    return {"size": pixels.shape[1::-1]}, pixels.tobytes()


read_film = Limited(f"{__name__}:decoded", seconds=20)
