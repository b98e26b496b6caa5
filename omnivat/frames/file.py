"""The frames file: everything the page draws while the order moves, as one binary.

Little endian. Eight bytes OVFRAMES, the length of the JSON as u32, the JSON (UTF-8, padded with
spaces so that what follows starts at a multiple of 8), then the arrays. An array's `offset` is
counted from the end of the JSON and is a multiple of 8. docs/frames.md lists the JSON's names.
Reading needs numpy alone.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.errors import DataError
from omnivat.files import replacing

MAGIC = b"OVFRAMES"
VERSION = 1
ALIGN = 8
DTYPES = {"u8": np.dtype("u1"), "u16": np.dtype("<u2")}
LEVELS = 65535  # steps of a quantised coordinate


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapFrames:
    """Maps of one stage by one method, quantised.

    points     (F, 2N, 2) u16: N VIS rows, then N TAC rows; 0 is `low` and 65535 is `high`
    orders     (F,) which stop each frame is for; one frame alone stands for every stop
    low, high  corners of a square that holds all frames
    max_error  largest distance between a drawn and a computed coordinate, in map units
    """

    points: NDArray[np.uint16]
    orders: tuple[int, ...]
    low: tuple[float, float]
    high: tuple[float, float]
    max_error: float

    def places(self, frame: int) -> NDArray[np.float64]:
        """Return the coordinates of a frame, (2N, 2), in map units."""
        span = np.subtract(self.high, self.low)
        return np.asarray(self.low) + self.points[frame] * (span / LEVELS)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrameSet:
    """What the page draws for N pairs at P orders.

    orders       (P,) quarter turns
    domain       (N,) u8 index into `domains`
    label        (N,) u8 index into `classes`
    prediction   (P, N) u8 fused class, an index into `classes`
    confidence   (P, N) u8 its probability, 255 is 1
    maps         "method/stage" -> frames
    curves       "measure/stage" -> P values; None where a value does not exist
    head         where the head comes from: learned order, source domain, hash
    embeddings   where the embeddings come from: encoder, weights' hash, simulated, origin
    """

    orders: tuple[float, ...]
    domains: tuple[str, ...]
    classes: tuple[str, ...]
    domain: NDArray[np.uint8]
    label: NDArray[np.uint8]
    prediction: NDArray[np.uint8]
    confidence: NDArray[np.uint8]
    maps: Mapping[str, MapFrames]
    curves: Mapping[str, list[float | None]]
    head: Mapping[str, Any] = field(default_factory=dict)
    embeddings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def pairs(self) -> int:
        """N."""
        return len(self.label)


def write_frames(path: str | Path, frames: FrameSet) -> None:
    """Write the frames whole or not at all. Maps that share one array store it once."""
    arrays: dict[str, NDArray[Any]] = {
        "domain": frames.domain,
        "label": frames.label,
        "prediction": frames.prediction,
        "confidence": frames.confidence,
    }
    named: dict[int, str] = {}
    maps = {}
    for name, frame in frames.maps.items():
        array = named.setdefault(id(frame.points), f"map:{name}")
        arrays[array] = frame.points
        maps[name] = {
            "array": array,
            "orders": list(frame.orders),
            "bounds": [list(frame.low), list(frame.high)],
            "max_error": frame.max_error,
        }
    entries, offset = {}, 0
    for name, array in arrays.items():
        kind = "u16" if array.dtype.itemsize == 2 else "u8"
        entries[name] = {"offset": offset, "dtype": kind, "shape": list(array.shape)}
        offset += array.nbytes + -array.nbytes % ALIGN
    record = {
        "version": VERSION,
        "orders": list(frames.orders),
        "pairs": frames.pairs,
        "domains": list(frames.domains),
        "classes": list(frames.classes),
        "arrays": entries,
        "maps": maps,
        "curves": dict(frames.curves),
        "head": dict(frames.head),
        "embeddings": dict(frames.embeddings),
    }
    text = json.dumps(record, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-(len(MAGIC) + 4 + len(text)) % ALIGN)
    with replacing(path) as temporary, temporary.open("wb") as handle:
        handle.write(MAGIC + len(text).to_bytes(4, "little") + text)
        for name, array in arrays.items():
            kind = DTYPES[entries[name]["dtype"]]  # type: ignore[index]
            handle.write(np.ascontiguousarray(array, dtype=kind).tobytes())
            handle.write(b"\0" * (-array.nbytes % ALIGN))


def read_frames(path: str | Path) -> FrameSet:
    """Read what `write_frames` wrote.

    Raises DataError, naming the file, when it is missing, cut short or of another kind.
    """
    file = Path(path)
    if not file.is_file():
        raise DataError(f"No frames file at '{file}'. Build one with `python -m omnivat frames`.")
    content = file.read_bytes()
    record, start = _record(file, content)
    try:
        arrays = {
            name: _array(file, content, start, name, entry)
            for name, entry in record["arrays"].items()
        }
        frames = FrameSet(
            orders=tuple(record["orders"]),
            domains=tuple(record["domains"]),
            classes=tuple(record["classes"]),
            **{name: arrays[name] for name in ("domain", "label", "prediction", "confidence")},
            maps={name: _map(entry, arrays) for name, entry in record["maps"].items()},
            curves=record["curves"],
            head=record["head"],
            embeddings=record["embeddings"],
        )
        if record["pairs"] != frames.pairs:
            raise ValueError(f"{record['pairs']} pairs stated, {frames.pairs} found")
        check(frames)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        if isinstance(error, DataError):
            raise
        raise DataError(
            f"'{file}' cannot be read as frames ({error!r}). Build it again with "
            "`python -m omnivat frames`."
        ) from error
    return frames


def _record(file: Path, content: bytes) -> tuple[dict[str, Any], int]:
    if content[: len(MAGIC)] != MAGIC:
        raise DataError(f"'{file}' is not a frames file: it does not start with OVFRAMES.")
    start = len(MAGIC) + 4 + int.from_bytes(content[len(MAGIC) : len(MAGIC) + 4], "little")
    try:
        record = json.loads(content[len(MAGIC) + 4 : start])
    except ValueError as error:
        raise DataError(f"'{file}' is cut short or damaged; build it again.") from error
    version = record.get("version") if isinstance(record, dict) else None
    if version != VERSION or start % ALIGN:
        raise DataError(
            f"'{file}' has frames of version {version}, wanted {VERSION}; build it again."
        )
    return record, start


def _array(
    file: Path, content: bytes, start: int, name: str, entry: Mapping[str, Any]
) -> NDArray[Any]:
    dtype, shape = DTYPES[entry["dtype"]], tuple(map(int, entry["shape"]))
    first, count = start + int(entry["offset"]), math.prod(shape)
    if min((0, *shape)) < 0 or first < start or first + count * dtype.itemsize > len(content):
        raise DataError(f"'{file}' is cut short: array '{name}' does not fit; build it again.")
    return np.frombuffer(content, dtype, count, first).reshape(shape)


def _map(entry: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> MapFrames:
    low, high = (tuple(map(float, corner)) for corner in entry["bounds"])
    return MapFrames(
        points=arrays[entry["array"]],
        orders=tuple(entry["orders"]),
        low=low,  # type: ignore[arg-type]
        high=high,  # type: ignore[arg-type]
        max_error=float(entry["max_error"]),
    )


def check(frames: FrameSet) -> None:
    """Refuse frames whose parts do not fit one another. Raises ValueError saying which."""
    stops, pairs = len(frames.orders), frames.pairs
    for name, wanted in (
        ("domain", (pairs,)),
        ("prediction", (stops, pairs)),
        ("confidence", (stops, pairs)),
    ):
        if getattr(frames, name).shape != wanted:
            raise ValueError(f"{name} has shape {getattr(frames, name).shape}, wanted {wanted}")
    for name, index, names in (
        ("domain", frames.domain, frames.domains),
        ("label", frames.label, frames.classes),
        ("prediction", frames.prediction, frames.classes),
    ):
        if index.size and index.max() >= len(names):
            raise ValueError(f"a {name} has no name")
    for name, values in frames.curves.items():
        if len(values) != stops:
            raise ValueError(f"curve {name} has {len(values)} values for {stops} orders")
    for name, frame in frames.maps.items():
        wanted_shape = (len(frame.orders), 2 * pairs, 2)
        if frame.points.shape != wanted_shape or frame.points.dtype.itemsize != 2:
            raise ValueError(f"map {name} has shape {frame.points.shape}, wanted {wanted_shape}")
        if not all(0 <= stop < stops for stop in frame.orders) or not frame.orders:
            raise ValueError(f"map {name} has a frame for a stop that is not there")
        if not all(math.isfinite(x) for x in (*frame.low, *frame.high, frame.max_error)):
            raise ValueError(f"map {name} has bounds that are not numbers")


def quantised(maps: list[NDArray[np.float64]], orders: tuple[int, ...]) -> MapFrames:
    """Quantise maps (2N, 2) of one stage to u16 inside one square that holds them all."""
    stacked = np.stack(maps).astype(np.float64)
    flat = stacked.reshape(-1, 2)
    lowest, highest = (flat.min(0), flat.max(0)) if len(flat) else (np.zeros(2), np.zeros(2))
    middle, half = (lowest + highest) / 2, max(float((highest - lowest).max()) / 2, 1e-12)
    low, high = middle - half, middle + half
    points = np.rint((stacked - low) * (LEVELS / (2 * half))).clip(0, LEVELS).astype("<u2")
    drawn = low + points * (2 * half / LEVELS)
    return MapFrames(
        points=points,
        orders=orders,
        low=(float(low[0]), float(low[1])),
        high=(float(high[0]), float(high[1])),
        max_error=float(np.abs(drawn - stacked).max()) if len(flat) else 0.0,
    )
