"""Pairs of pictures from recordings: LeRobot data sets with tactile images, videos with a table of
labels, and the recordings of tactile packages.
"""

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from omnivat.data.class_labels import class_names
from omnivat.data.materials import NO_CLASS, class_key
from omnivat.data.naming import (
    TACTILE,
    VIDEOS,
    checked_split,
    found_file,
    half_of,
    one_spelling,
    without_half,
)
from omnivat.data.pairs import Pair
from omnivat.data.readers import read_pairs
from omnivat.data.readers.files import TABLES, number_in, numbered_rows, show, visible
from omnivat.data.readers.table import rows_of
from omnivat.data.recordings.lerobot import INFO, LeRobot
from omnivat.data.recordings.stacks import count_in, stack
from omnivat.data.recordings.stored import stored_clips, stored_files
from omnivat.data.recordings.tactile import tactile_clips, tactile_track
from omnivat.data.recordings.tracks import Clip, Film, Track
from omnivat.data.recordings.writing import write_pairs
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.stages import IMAGES

__all__ = ["clips_of", "is_recording", "write_pairs"]

TABLE = "videos.csv"  # of a folder of videos
DAY = 86_400.0  # seconds; no recording of a contact is longer
HEAD = 16_384  # bytes of a table that are searched for names of recordings
RECORDED = (*VIDEOS, *TACTILE)


def is_recording(source: Path) -> bool:
    """True for a LeRobot data set, a table of videos or a folder that holds one, and recordings of
    tactile packages.
    """
    if source.suffix.lower() in TACTILE:
        return True
    if source.is_dir():
        return (source / INFO).is_file() or bool(_tactile(source)) or _table(source) is not None
    return source.is_file() and source.suffix.lower() in TABLES and _names_recordings(source)


def _names_recordings(table: Path) -> bool:
    cells: set[str] = set()
    if table.suffix.lower() == ".xlsx":
        cells = _cells(table)
        if any(cell.endswith(RECORDED) for cell in cells):
            return True
    else:
        with table.open("rb") as file:
            head = file.read(HEAD).replace(b"\0", b"").lower()
        if any(ending.encode() in head for ending in RECORDED):
            return True
    films = [e.name.lower() for e in visible(table.parent) if e.name.lower().endswith(RECORDED)]
    stems = {os.path.splitext(name)[0] for name in films}  # suffixes may be left out
    return bool(stems) and not stems.isdisjoint(cells or _cells(table))


def _cells(table: Path) -> set[str]:
    return {cell.lower() for row in numbered_rows(table).values() for cell in row}


def _has_halves(table: Path) -> bool:
    """Return whether a table has a column of photos or touches."""
    header = next(iter(numbered_rows(table).values()), [])
    return any(half_of(name) in IMAGES for name in header)


def _table(folder: Path) -> Path | None:
    """Return the table of videos in a folder, or None without one.

    Raises DataError if there are several.
    """
    files = [folder / entry.name for entry in visible(folder) if entry.is_file()]
    found = [f for f in files if f.suffix.lower() in TABLES and _names_recordings(f)]
    if (folder / TABLE).is_file():
        return folder / TABLE
    if len(found) > 1:
        names = ", ".join(show(file.name) for file in found)
        raise DataError(f"'{show(folder)}' has several tables of recordings ({names}); name one.")
    return found[0] if found else None


def _tactile(folder: Path) -> list[Path]:
    """Return the recordings of tactile packages in a folder and below."""
    here = [folder / entry.name for entry in visible(folder)]
    found = [place for place in here if place.name.lower().endswith(TACTILE)]
    inner = [p for p in here if p not in found and p.is_dir() and not p.is_symlink()]
    return found + [place for folder in inner for place in _tactile(folder)]


def clips_of(source: Path, *, classes: Sequence[str] = (), **how: Any) -> list[Clip]:
    """Return the recordings in `source`, or its pairs of pictures.

    classes  names of numbered classes
    how      as `_clips_of`

    Raises DataError for another layout, or if the cameras cannot be told.
    """
    clips = _clips_of(source, classes=classes, **how)
    known = [k for k, clip in enumerate(clips) if clip.material not in ("", NO_CLASS)]
    if classes:
        named = class_names([clips[k].material for k in known], classes, source)
        for k, name in zip(known, named, strict=True):
            clips[k] = replace(clips[k], material=class_key(name))
    things, places = (one_spelling(getattr(c, n) for c in clips) for n in ("object", "domain"))
    return [
        replace(clip, object=thing, domain=place)
        for clip, thing, place in zip(clips, things, places, strict=True)
    ]


def _clips_of(
    source: Path,
    *,
    vis: str = "",
    tac: Sequence[str] = (),
    domain: str = "",
    labels: Path | None = None,
    classes: Sequence[str] = (),
    columns: Mapping[str, str] | None = None,
) -> list[Clip]:
    """Return the recordings in `source`, or its pairs of pictures.

    vis, tac  names of cameras, columns of pictures, or folders; "" and (): by their words
    domain    of all pairs; "": the name of the data set or of the sensor, or of the tactile camera
              if there are several
    labels    a table with the columns episode (of LeRobot and groups) or file, material, perhaps
              domain, object, split
    classes   names of numbered classes, of pictures in a file
    columns   name here -> name in such a file, if they differ

    Raises DataError for another layout, or if the cameras cannot be told.
    """
    if source.is_dir() and (source / INFO).is_file():
        return LeRobot(source).clips(vis, tac, domain, labels)
    tactile = source.suffix.lower() in TACTILE
    files = [source] if tactile else _tactile(source) if source.is_dir() else []
    own = _table(source) if files and not tactile else None
    if files and not (own and _has_halves(own)):
        labels = labels or own  # a table with a column file
        return [clip for file in files for clip in tactile_clips(file, domain, labels)]
    if stored_files(source):
        return stored_clips(
            source,
            vis=vis,
            tac=tac,
            domain=domain,
            classes=classes,
            columns=columns or {},
            labels=labels,
        )
    if labels or len(tac) > 1:
        raise SettingsError("--labels and several --tac are for LeRobot; a table has its labels.")
    if not is_recording(source):
        return _paired(source, vis, "".join(tac))
    table = (_table(source) if source.is_dir() else source) or source / TABLE
    rows, cameras = rows_of(table, vis=vis, tac="".join(tac), domain=domain)
    return [_clip(table, number, row, domain, cameras) for number, row in rows.items()]


def _paired(source: Path, vis: str, tac: str) -> list[Clip]:
    """Return the pairs of a folder or a table of pictures."""
    options: dict[str, Any] = {half: n for half, n in (("vis", vis), ("tac", tac)) if n}
    found = read_pairs(source, **options)

    def read(pair: Pair) -> tuple[dict[str, Track], float]:
        halves = [half for half in IMAGES if pair.alone in ("", half)]
        return {half: stack(getattr(pair, half)) for half in halves}, 1.0

    counts = [count_in(pair.vis if pair.alone == "vis" else pair.tac) for pair in found.pairs]
    left_out = [
        Clip(read=partial(_refused, skip.why), name=skip.what, domain="", material="", object="")
        for skip in found.skipped
    ]
    return left_out + [
        Clip(
            read=partial(read, pair),
            name=without_half(pair.vis.stem),
            domain=pair.domain,
            material=pair.material,
            object=pair.object or pair.tac.name * (count > 1),
            split=pair.split,
            cameras=found.origin + "; some pictures are films" * (max(counts) > 1),
            frames=count,
        )
        for pair, count in zip(found.pairs, counts, strict=True)
    ]


def _refused(why: str) -> tuple[dict[str, Track], None]:
    raise DataError(why)


def _clip(file: Path, number: int, row: Mapping[str, str], domain: str, cameras: str) -> Clip:
    """Return the recording of a row: vis and tac name videos; start and end are seconds."""
    where = f"'{show(file)}', row {number}"
    return Clip(
        read=partial(_filmed, file.parent, row),
        name=f"row {number}",
        domain=row["domain"] or domain or show(file.absolute().parent.name),
        material=class_key(row["material"]) or NO_CLASS,
        object=row["object"]
        or " ".join(filter(None, (row["tac"] or row["vis"], class_key(row["material"])))),
        split=checked_split(row.get("split", ""), where),
        cameras=cameras,
    )


def _seconds(text: str, name: str) -> float:
    """Return the seconds in a text such as "2,5", "1:30" or "00:01:30"."""
    parts = text.replace(",", ".").split(":")
    numbers = [number_in(part, -DAY, DAY, name) for part in parts[-3:]]
    return float(sum(number * 60.0**k for k, number in enumerate(reversed(numbers))))


def _filmed(folder: Path, row: Mapping[str, str]) -> tuple[dict[str, Track], float | None]:
    """Return the tracks of a row, and its length in seconds; None for the video's."""
    given = [name for name in ("start", "end", "tac_delay") if row.get(name)]
    seconds = {name: _seconds(row[name], name) for name in given}
    if seconds.get("end", DAY) <= seconds.get("start", 0.0):
        raise DataError(f"Its end, {row['end']} s, is not after its start.")
    start, delay = seconds.get("start", 0.0), {"vis": 0.0, "tac": seconds.get("tac_delay", 0.0)}
    names = {half: row[half] for half in IMAGES if row.get(half)}
    if not names:
        raise DataError("It names no video; name one under vis or tac.")
    tracks: dict[str, Track] = {}
    for half, name in names.items():
        file, begin = found_file(folder, name), start + delay[half]
        if os.path.splitext(name)[1].lower() in TACTILE:
            frames = tactile_track(file)
            tracks[half] = replace(frames, times=[time - begin for time in frames.times])
        else:
            tracks[half] = Film(file=file, start=begin)
    return tracks, seconds["end"] - start if "end" in seconds else None
