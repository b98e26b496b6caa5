"""Recordings of tactile packages: `.hapt` folders of haptix, and `.touch` files of the OpenTouch
Interface.

A `.hapt` folder holds `manifest.json`, `raw/data.npy` (T, H, W, C) with `raw/checksum.sha256`, and
`labels.json`. A `.touch` file is HDF5: `config`, a JSON text, and `sensor_chunks`, each of which
packs events of named sensors and streams, as little-endian numbers of 4 bytes before texts, lists
and events; an event is its stream's name (32 bytes), its time (a double) and, of a camera, height,
width, channels and pixels.
"""

import hashlib
import struct
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from omnivat.data.hdf5 import Stored, arrays
from omnivat.data.images import from_array
from omnivat.data.materials import NO_CLASS, class_key
from omnivat.data.naming import COLUMNS, checked_split, composed
from omnivat.data.readers.files import number_in, read_labels, show
from omnivat.data.recordings.tracks import Clip, Frames, Track
from omnivat.kit.errors import DataError, OmniVatError, first_line
from omnivat.kit.files import require_regular
from omnivat.kit.schema import object_in, read_object

EVENT, SHAPE = struct.Struct("<32sd"), struct.Struct("<III")
CHUNKS = "sensor_chunks"
MOST_RATE = 1e6  # pictures a second
# how to read a sensor's pictures, and its domain, material and object
Sensors = dict[str, tuple[Callable[[], Frames], Mapping[str, str]]]


def tactile_clips(file: Path, domain: str, labels: Path | None = None) -> list[Clip]:
    """Return the recordings of a file, one for each of its cameras.

    domain  of all; "": the sensor's type and number
    labels  a table whose column file names recordings
    A file that cannot be read gives one whose reading raises DataError.
    """
    table = read_labels(labels, "file") if labels else {}
    place = composed(file.as_posix())
    names = [key for key in table if place.endswith(f"/{key}") or key == composed(file.stem)]
    row = table[max(names, key=len)] if names else {}
    try:
        sensors = _hapt(file) if file.suffix.lower() == ".hapt" else _touch(file)
    except OmniVatError as error:
        sensors = {"": (partial(_refused, str(error)), {})}
    clips = []
    for name, (track, stated) in sensors.items():
        thing = row.get("object") or stated.get("object", "")
        clips.append(
            Clip(
                read=partial(_read, track),
                name=f"{file.stem} {name}".rstrip(),
                domain=row.get("domain") or domain or stated.get("domain") or file.stem,
                material=class_key(row.get("material") or stated.get("material") or thing)
                or NO_CLASS,
                object=thing or file.stem,
                split=checked_split(row.get("split", ""), f"--labels, file {file.name}"),
                cameras=f"photo none, touch {stated['domain']}" if stated else "",
            )
        )
    return clips


def tactile_track(file: Path) -> Frames:
    """Return the pictures of a recording of one sensor; raises DataError for several."""
    sensors = _hapt(file) if file.suffix.lower() == ".hapt" else _touch(file)
    if len(sensors) != 1:
        raise DataError(f"'{show(file)}' has {len(sensors)} cameras; import the file itself.")
    (frames,) = (track() for track, _ in sensors.values())
    return frames


def _read(track: Callable[[], Frames]) -> tuple[dict[str, Track], None]:
    return {"tac": track()}, None


def _refused(why: str) -> Frames:
    raise DataError(why)


def _hapt(folder: Path) -> Sensors:
    """Return the one sensor of a `.hapt` folder."""
    if not folder.is_dir():
        raise DataError(
            f"'{show(folder)}' is no folder; write it with haptix.save(data, NAME.hapt)."
        )
    manifest, own = read_object(folder / "manifest.json"), folder / "labels.json"
    labels = read_object(own) if own.exists() else {}
    sensor, sampling = (_part(manifest, name, folder) for name in ("sensor", "sampling"))
    rate = number_in(sampling.get("rate_hz"), 1e-3, MOST_RATE, f"rate_hz of '{show(folder)}'")
    stated = {name: str(labels.get(name) or "") for name in ("material", "object")}
    stated["material"] = stated["material"] or str(labels.get("material_category") or "")
    kind, serial = (str(sensor.get(name) or "") for name in ("type", "serial"))
    track = partial(_hapt_frames, folder, rate, sampling.get("timestamps_s"))
    return {"": (track, stated | {"domain": f"{kind} {serial}".strip()})}


def _part(manifest: Mapping[str, Any], name: str, folder: Path) -> Mapping[str, Any]:
    found = manifest.get(name)
    if not isinstance(found, dict):
        raise DataError(f"'{show(folder / 'manifest.json')}' has no {name}.")
    return found


def _hapt_frames(folder: Path, rate: float, stamps: Any) -> Frames:
    file, sums = folder / "raw" / "data.npy", folder / "raw" / "checksum.sha256"
    require_regular(file, show(file))
    try:
        frames = np.load(file, mmap_mode="r", allow_pickle=False)
        digest = hashlib.sha256(np.ascontiguousarray(frames).data).hexdigest()
        expected = sums.read_text().strip() if sums.is_file() else digest
    except Exception as error:  # NumPy has many kinds for a damaged header
        raise DataError(f"'{show(file)}' cannot be read ({first_line(error)}).") from error
    if digest != expected:
        raise DataError(f"'{show(file)}' does not have its checksum; copy the recording again.")
    if frames.ndim != 4 or frames.shape[-1] not in (1, 3, 4):
        raise DataError(f"'{show(file)}' holds {frames.shape}, and pictures are (T, H, W, C).")
    regular = not isinstance(stamps, list) or len(stamps) != len(frames)
    times = [k / rate for k in range(len(frames))] if regular else _rising(stamps, file)
    return Frames(
        file=file,
        times=times,
        picture=lambda k: from_array(np.array(frames[k]), f"{folder.name}, picture {k}"),
    )


def _rising(stamps: list[Any], file: Path) -> list[float]:
    times = [number_in(stamp, -1e12, 1e12, f"a time of '{show(file)}'") for stamp in stamps]
    if sorted(times) != times:
        raise DataError(f"The times of '{show(file)}' do not rise.")
    return [time - times[0] for time in times]


def _touch(file: Path) -> Sensors:
    """Return the cameras of a `.touch` file by their sensors."""
    there, _ = arrays(file)
    if missing := [name for name in ("config", CHUNKS) if name not in there]:
        raise DataError(f"'{show(file)}' has no {missing[0]}, as a .touch file does.")
    config = object_in(str(there["config"][()]).encode(), f"config of '{show(file)}'")
    payload = {
        str(entry.get("label", "")).lower(): str(entry.get("default") or "")
        for entry in _list(config, "payload")
    }
    stated = {name: _payload(payload, name) for name in ("material", "object")}
    found: Sensors = {}
    for sensor in _list(config, "sensors"):
        name = str(sensor.get("sensor_name", ""))
        number = sensor.get("serial_id") or name
        domain = f"{sensor.get('sensor_type', 'sensor')} {number}".strip()
        found[name] = partial(_touch_frames, file, name, there[CHUNKS]), stated | {"domain": domain}
    return found


def _list(config: Mapping[str, Any], name: str) -> list[Mapping[str, Any]]:
    found = config.get(name)
    return [entry for entry in found if isinstance(entry, dict)] if isinstance(found, list) else []


def _payload(payload: Mapping[str, str], name: str) -> str:
    """Return the label that a person gave a recording under a name with this word."""
    words = {name, *COLUMNS[name]}
    return next((value for key, value in payload.items() if words & {*key.split()} and value), "")


def _touch_frames(file: Path, sensor: str, chunks: Stored) -> Frames:
    """Return a sensor's pictures; one chunk of the file is in memory at a time."""
    places: list[tuple[float, int, int, int]] = []  # time, chunk, first and last byte

    @lru_cache(maxsize=1)
    def chunk(number: int) -> bytes:
        return chunks[number].tobytes()

    try:
        for number in range(len(chunks)):
            for start, end in _events(content := chunk(number), sensor):
                stream, time = EVENT.unpack_from(content, start)
                if stream.rstrip(b"\0") == b"camera":
                    places.append((time, number, start + EVENT.size, end))
    except (struct.error, LookupError, ValueError) as error:
        why = f" ({first_line(error)})" if isinstance(error, DataError) else ""
        raise DataError(
            f"'{show(file)}' is damaged after {len(places)} pictures{why.rstrip('.')}."
        ) from error
    places.sort()

    def picture(k: int) -> Image.Image:
        _, number, start, end = places[k]
        content = chunk(number)[start:end]
        shape = SHAPE.unpack_from(content) if len(content) >= SHAPE.size else (0, 0, 0)
        if shape[2] not in (1, 3, 4) or np.prod(shape, dtype=np.int64) != len(content) - SHAPE.size:
            raise DataError(f"'{show(file)}' has no whole picture {k} of '{show(sensor)}'.")
        pixels = np.frombuffer(content, np.uint8, offset=SHAPE.size).reshape(shape)
        return from_array(pixels, f"{file.name}, picture {k}")

    if not places:
        raise DataError(f"'{show(file)}' has no pictures of '{show(sensor)}'.")
    times = _rising([time for time, *_ in places], file)
    return Frames(file=file, times=times, picture=picture)


def _events(chunk: bytes, wanted: str) -> Iterator[tuple[int, int]]:
    """Yield the first and last byte of each event of a sensor; raises ValueError or struct.error
    for a damaged chunk.
    """
    at = 0

    def number() -> int:
        nonlocal at
        at += 4
        return int(struct.unpack_from("<I", chunk, at - 4)[0])

    def skipped(length: int) -> tuple[int, int]:
        nonlocal at
        at += length
        if at > len(chunk):
            raise ValueError("cut short")
        return at - length, at

    for _ in range(number()):
        start, end = skipped(number())
        mine = chunk[start:end].decode(errors="replace") == wanted
        for _ in range(number()):
            skipped(number())
            for _ in range(number()):
                place = skipped(number())
                if mine:
                    yield place
