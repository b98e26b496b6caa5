"""A file of frames in parts, so that a page shows the first map before the others have come.

head        the JSON of the file, with curves of six digits, `domain` and `label` in base64, and the
            box around the VIS and the TAC points of each map over all its stops
NAME        one array of the file; of a map, its stops from one of them outward
"""

import base64
import json
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.kit.errors import DataError

if TYPE_CHECKING:
    import numpy as np

HEAD = "head"
INLINE = ("domain", "label")


def tag_of(file: Path) -> str:
    """Return a short name of a file's version."""
    found = file.stat()
    return f"{found.st_mtime_ns:x}-{found.st_size:x}"


def part_of(file: Path, name: str, start: int = 0) -> bytes:
    """Return one part of a frames file.

    start  of a map: the index of the stop that comes first; the others follow by their distance

    Raises DataError for a part or a stop that the file lacks.
    """
    if name == HEAD:
        return _head(file, tag_of(file))
    entry, content = _array(file, name)
    stops = entry["shape"][0] if len(entry["shape"]) == 3 else 1
    if not 0 <= start < stops:
        raise DataError(f"There is no stop {start} in '{name:.40}'; there are {stops}.")
    size = len(content) // stops
    order = sorted(range(stops), key=lambda stop: abs(stop - start))
    return b"".join(content[stop * size : (stop + 1) * size] for stop in order)


def parts_of(file: Path) -> Iterator[tuple[str, bytes]]:
    """Yield every part of a frames file that a page fetches, with its name."""
    head = part_of(file, HEAD)
    yield HEAD, head
    for name in json.loads(head)["arrays"]:
        if name not in INLINE:
            yield name, part_of(file, name)


@lru_cache(maxsize=8)
def _head(file: Path, tag: str) -> bytes:
    from omnivat.maps.frames.file import frames_header, read_frames

    frames, record = read_frames(file), frames_header(file)
    extents = {
        entry["array"]: [_box(half) for half in _halves(frames.maps[name].points)]
        for name, entry in record["maps"].items()
    }
    curves = {
        name: [None if v is None else float(f"{v:.6g}") for v in values]
        for name, values in record["curves"].items()
    }
    inline = {name: base64.b64encode(getattr(frames, name).tobytes()).decode() for name in INLINE}
    whole = {**record, "curves": curves, "inline": inline, "extents": extents, "tag": tag}
    return json.dumps(whole, ensure_ascii=False, separators=(",", ":")).encode()


def _halves(points: "np.ndarray[Any, Any]") -> "tuple[Any, Any]":
    half = points.shape[1] // 2
    return points[:, :half], points[:, half:]


def _box(points: "np.ndarray[Any, Any]") -> list[int]:
    """Return left, bottom, right and top of positions (F, N, 2)."""
    rows = points.reshape(-1, 2)
    return [*rows.min(0).tolist(), *rows.max(0).tolist()]


def _array(file: Path, name: str) -> tuple[dict[str, Any], bytes]:
    """Return the entry and the bytes of one array."""
    import math

    record = json.loads(_head(file, tag_of(file)))
    entry = record["arrays"].get(name)
    if entry is None:
        raise DataError(f"There is no part '{name:.40}' in these frames.")
    size = math.prod(entry["shape"]) * {"u8": 1, "u16": 2}[entry["dtype"]]
    with file.open("rb") as handle:
        handle.seek(8)
        start = 12 + int.from_bytes(handle.read(4), "little")
        handle.seek(start + entry["offset"])
        return entry, handle.read(size)
