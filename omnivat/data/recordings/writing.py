"""Write pictures of recordings as a folder of pairs."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

from omnivat.data.pairs import Skipped
from omnivat.data.readers.files import show
from omnivat.data.recordings.tracks import Clip, Track
from omnivat.kit.errors import DataError, WriteError
from omnivat.kit.files import replacing_folder, write_csv
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.stages import IMAGES

GRID = 16  # blocks along a side, of which contact changes some; other light changes all of them
LOOKS = 60  # moments of a recording that are compared with its first one
UNEQUAL = 0.1  # relative difference of two lengths from which it is reported
MOST_BYTES = 200  # of a folder's name; file systems allow 255
COLUMNS = ("vis", "tac", "domain", "material", "object", "split")


class Written(NamedTuple):
    """What `write_pairs` wrote: pairs, recordings that were left out, recordings whose two films
    differ in length, cameras.
    """

    pairs: int
    skipped: list[Skipped]
    unequal: list[str]
    cameras: list[str]


def write_pairs(
    clips: Sequence[Clip],
    out: Path,
    *,
    frames: int = 5,
    pick: str = "even",
    align: str = "time",
    on_step: OnStep = ignore,
) -> Written:
    """Write pictures of each recording into a new folder that `omnivat embed` and `try` read.

    frames  pairs of each recording, which are one object: no split divides them
    pick    "even": in the middle of `frames` equal parts; "contact": of 60 moments, those whose
            touch differs most from the first one
    align   of a photo film and a touch film: "time": one moment of both, as long as both last;
            "share": one share of each film's own length

    The folder appears when it is complete. Raises WriteError if it exists with files, DataError if
    no recording can be read.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise WriteError(f"'{out}' exists; name a new folder.")
    skipped: list[Skipped] = []
    unequal: list[str] = []
    rows: list[list[str]] = []
    with replacing_folder(out) as work:
        for done, clip in enumerate(clips):
            on_step(Step(done=done, total=len(clips), text=clip.name))
            try:
                tracks, length = clip.read()
                times = moments(tracks, length, min(frames, clip.frames or frames), pick, align)
                shots = {half: list(t.pictures(times[half])) for half, t in tracks.items()}
            except DataError as error:
                skipped.append(Skipped(what=clip.name, why=str(error)))
                continue
            ends = [track.shown(length)[1] for track in tracks.values()]
            if max(ends) - min(ends) > UNEQUAL * max(ends):
                unequal.append(f"{clip.name} ({', '.join(f'{end:.1f} s' for end in ends)})")
            rows += _saved(clip, shots, work, done)
        if not rows:
            why = [f" The first, '{skip.what}': {skip.why.rstrip('.')}." for skip in skipped[:1]]
            raise DataError(f"None of the {len(clips)} recordings can be read.{''.join(why)}")
        write_csv(work / "pairs.csv", COLUMNS, rows)
    cameras = dict.fromkeys(clip.cameras for clip in clips if clip.cameras)
    return Written(len(rows), skipped, unequal, [*cameras])


def _saved(
    clip: Clip, shots: Mapping[str, Sequence[Image.Image]], work: Path, number: int
) -> list[list[str]]:
    """Write the pictures of a recording below `work`; return the rows of its pairs."""
    stem = "/".join(plain(part) for part in (clip.domain, clip.material, clip.name))
    still = "_" if clip.frames == 1 else "/000_"
    if any((work / f"{stem}{still}{half}.png").exists() for half in shots):
        stem = f"{stem} - {number}"  # plain and shortened names may be equal
    (work / f"{stem}{still}").parent.mkdir(parents=True, exist_ok=True)
    rows = []
    for k in range(len(next(iter(shots.values())))):
        names = {half: f"{stem}{still.replace('000', f'{k:03d}')}{half}.png" for half in shots}
        for half, name in names.items():
            shots[half][k].save(work / name)
        files = [names.get(half, "") for half in IMAGES]
        rows.append([*files, clip.domain, clip.material, clip.object, clip.split])
    return rows


def moments(
    tracks: Mapping[str, Track],
    length: float | None,
    frames: int,
    pick: str = "even",
    align: str = "time",
) -> dict[str, list[float]]:
    """Return the moments of `frames` pictures of each track, in seconds from its start.

    length  of the recording, in seconds; None: as long as its pictures last
    Raises DataError if a track has no pictures there, or the touch has fewer than `frames`.
    """
    spans = {half: track.shown(length) for half, track in tracks.items()}
    shared = min(end for _, end in spans.values())
    ends = {half: end if align == "share" else shared for half, (_, end) in spans.items()}
    touch = max(tracks, key=("vis", "tac").index)
    for half, track in tracks.items():
        there = int((spans[half][0] < ends[half]).sum())
        if there < (frames if half == touch else 1):
            raise DataError(
                f"'{show(track.file)}' has too few pictures in that time: {there} of {frames};"
                " choose fewer with --frames, or another start and end."
            )

    def even(count: int) -> list[float]:
        return [(k + 0.5) / count for k in range(count)]

    shares = even(frames)
    if pick == "contact":
        looks = even(max(frames, min(LOOKS, len(spans[touch][0]))))
        small = [
            np.asarray(picture.convert("L").resize((GRID, GRID), Image.Resampling.BOX), float)
            for picture in tracks[touch].pictures([share * ends[touch] for share in looks])
        ]
        change = np.array(small) - small[0]
        off = np.abs(change - np.median(change, axis=(1, 2), keepdims=True)).max(axis=(1, 2))
        shares = [looks[k] for k in sorted(np.argsort(-off, kind="stable")[:frames])]
    return {half: [share * ends[half] for share in shares] for half in tracks}


def plain(name: str) -> str:
    """Return a name as a folder.

    >>> plain("wood / oak"), plain("..")
    ('wood - oak', '-')
    """
    found = re.sub(r"[^\w .()+-]+|^\.+", "-", name).strip()[:80]
    return found.encode()[:MOST_BYTES].decode(errors="ignore") or "-"
