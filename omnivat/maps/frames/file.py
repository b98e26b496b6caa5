"""The frames file: the page's data for all stops of p, as one binary.

The format is in docs/gaps.md. Reading needs only numpy.
"""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.kit.errors import DataError, first_line
from omnivat.kit.files import path_of, reading, replacing
from omnivat.maps.frames.records import FrameSet, MapFrames, require_fit

MAGIC = b"OVFRAMES"
VERSION = 1
ALIGN = 8
DTYPES: dict[str, np.dtype[Any]] = {"u8": np.dtype("u1"), "u16": np.dtype("<u2")}
FACTS = ("curves", "head", "embeddings")
INDEXES = ("domain", "label", "prediction", "confidence")


def write_frames(path: str | Path, frames: FrameSet) -> None:
    """Write the frames, completely or not at all. A shared array is stored once."""
    blobs: list[bytes] = []
    entries: dict[str, dict[str, Any]] = {}
    offset = 0
    maps, arrays = _named(frames)
    for name, array in arrays.items():
        kind = "u16" if array.dtype.itemsize == 2 else "u8"
        blob = np.ascontiguousarray(array, dtype=DTYPES[kind]).tobytes()
        entries[name] = {"offset": offset, "dtype": kind, "shape": array.shape}
        blobs.append(blob + b"\0" * (-len(blob) % ALIGN))
        offset += len(blobs[-1])
    record: dict[str, Any] = {
        "version": VERSION,
        "orders": frames.orders,
        "pairs": frames.pairs,
        "domains": frames.domains,
        "classes": frames.classes,
        "arrays": entries,
        "maps": maps,
    }
    record |= {name: getattr(frames, name) for name in FACTS}
    text = json.dumps(record, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-(len(MAGIC) + 4 + len(text)) % ALIGN)
    with replacing(path) as temporary:
        temporary.write_bytes(b"".join([MAGIC, len(text).to_bytes(4, "little"), text, *blobs]))


def _named(frames: FrameSet) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return the maps' JSON, and every array by name; a shared array appears once."""
    arrays: dict[str, NDArray[Any]] = {name: getattr(frames, name) for name in INDEXES}
    names: dict[int, str] = {}
    maps = {}
    for name, track in frames.maps.items():
        array = names.setdefault(id(track.points), f"map:{name}")
        arrays[array] = track.points
        maps[name] = {
            "array": array,
            "orders": track.orders,
            "bounds": [track.low, track.high],
            "max_error": track.max_error,
            "trust": track.trust,
        }
    return maps, arrays


def read_frames(path: str | Path) -> FrameSet:
    """Read a frames file.

    Raises DataError with the file name if the file is missing, truncated or of another kind.

    >>> frames = read_frames("examples/frames.bin")
    >>> frames.domains[0], frames.classes[:2], len(frames.orders)
    ('TAG-sim', ('wood', 'steel'), 102)
    """
    file = path_of(path)
    record, start = _header(file)
    content = file.read_bytes()
    try:
        arrays = {
            name: _array(file, content, start, name, entry)
            for name, entry in record["arrays"].items()
        }
        known: dict[str, Any] = {
            name: tuple(record[name]) for name in ("orders", "domains", "classes")
        }
        known |= {name: arrays[name] for name in INDEXES} | {name: record[name] for name in FACTS}
        frames = FrameSet(
            **known, maps={name: _map(entry, arrays) for name, entry in record["maps"].items()}
        )
        if record["pairs"] != frames.pairs:
            raise ValueError(f"{record['pairs']} pairs stated, {frames.pairs} found")
        require_fit(frames)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        if isinstance(error, DataError):
            raise
        raise DataError(
            f"'{file}' cannot be read as frames ({first_line(error)}). Build it again with"
            " `python -m omnivat sweep`."
        ) from error
    return frames


def frames_header(path: str | Path) -> dict[str, Any]:
    """Return the JSON of a frames file without reading its arrays; raises as `read_frames` does."""
    return _header(path_of(path))[0]


def _header(file: Path) -> tuple[dict[str, Any], int]:
    """Return the JSON, and the offset of the first array in bytes."""
    if not file.is_file():
        raise DataError(f"No frames file at '{file}'. Build one with `python -m omnivat sweep`.")
    with reading(str(file)), file.open("rb") as handle:
        if handle.read(len(MAGIC)) != MAGIC:
            raise DataError(f"'{file}' is not a frames file: it does not start with OVFRAMES.")
        length = int.from_bytes(handle.read(4), "little")
        text = handle.read(length) if length <= file.stat().st_size else b""
    try:
        record = json.loads(text)
    except ValueError as error:
        raise DataError(f"'{file}' is cut short or damaged; build it again.") from error
    start = len(MAGIC) + 4 + length
    version = record.get("version") if isinstance(record, dict) else None
    if version != VERSION or start % ALIGN:
        raise DataError(
            f"'{file}' has frames of version {version}, expected {VERSION}; build it again."
        )
    return record, start


def _array(
    file: Path, content: bytes, start: int, name: str, entry: Mapping[str, Any]
) -> NDArray[Any]:
    dtype, shape = DTYPES[entry["dtype"]], tuple(map(int, entry["shape"]))
    first, count = start + int(entry["offset"]), math.prod(shape)
    if min((0, *shape)) < 0 or first < start or first + count * dtype.itemsize > len(content):
        raise DataError(f"'{file}' is cut short: array '{name}' does not fit; build it again.")
    array: NDArray[Any] = np.frombuffer(content, dtype, count, first).reshape(shape)
    return array


def _map(entry: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> MapFrames:
    low, high = entry["bounds"]
    return MapFrames(
        points=arrays[entry["array"]],
        orders=tuple(entry["orders"]),
        low=tuple(low),
        high=tuple(high),
        max_error=entry["max_error"],
        trust=tuple(entry["trust"]),
    )
