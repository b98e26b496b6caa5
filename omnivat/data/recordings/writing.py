"""Write pictures of recordings as a folder of pairs."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from omnivat.data.pairs import Skipped
from omnivat.data.readers.files import show
from omnivat.data.recordings.tracks import Clip, Track, extent, pictures
from omnivat.kit.errors import DataError, WriteError
from omnivat.kit.files import replacing_folder, write_csv
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.stages import IMAGES

GRID = 16  # blocks along a side, of which contact changes some; other light changes all of them
LOOKS = 60  # moments of a recording that are compared with its first one
COLUMNS = ("vis", "tac", "domain", "material", "object", "split")


def write_pairs(
    clips: Sequence[Clip],
    out: Path,
    *,
    frames: int = 5,
    pick: str = "even",
    on_step: OnStep = ignore,
) -> tuple[int, list[Skipped]]:
    """Write pictures of each recording into a new folder that `omnivat embed` and `try` read.

    frames  pairs of each recording, which are one object: no split divides them
    pick    "even": in the middle of `frames` equal parts; "contact": of 60 moments, those whose
            touch differs most from the first one
    return  number of pairs; recordings that were left out, with reasons

    The folder appears when it is complete. Raises WriteError if it exists with files, DataError if
    no recording can be read.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise WriteError(f"'{out}' exists; name a new folder.")
    with replacing_folder(out) as work:
        rows, skipped = _written(clips, work, frames, pick, on_step)
        if all(row[0] and row[1] for row in rows):  # else names tell the one modality
            write_csv(work / "pairs.csv", COLUMNS, rows)
    return len(rows), skipped


def _written(
    clips: Sequence[Clip], work: Path, frames: int, pick: str, on_step: OnStep
) -> tuple[list[list[str]], list[Skipped]]:
    rows, skipped = [], []
    for done, clip in enumerate(clips):
        on_step(Step(done=done, total=len(clips), text=clip.name))
        try:
            tracks, length = clip.read()
            times = moments(tracks.get("tac") or tracks["vis"], length, frames, pick)
            shots = {half: list(pictures(track, times)) for half, track in tracks.items()}
        except DataError as error:
            skipped.append(Skipped(what=clip.name, why=str(error)))
            continue
        folder = Path(*(plain(part) for part in (clip.domain, clip.material, clip.name)))
        if (work / folder).exists():  # plain and shortened names may be equal
            folder = folder.with_name(f"{folder.name} - {done}")
        (work / folder).mkdir(parents=True, exist_ok=True)
        for k in range(frames):
            names = {half: str(folder / f"{k:03d}_{half}.png") for half in shots}
            for half, name in names.items():
                shots[half][k].save(work / name)
            files = [names.get(half, "") for half in IMAGES]
            rows.append([*files, clip.domain, clip.material, clip.object, clip.split])
    if not rows:
        why = f" The first, '{skipped[0].what}': {skipped[0].why}" if skipped else ""
        raise DataError(f"None of the {len(clips)} recordings can be read.{why}")
    return rows, skipped


def moments(track: Track, length: float | None, frames: int, pick: str) -> list[float]:
    """Return the moments of a recording of `length` seconds (None: the video's), in seconds from
    its start."""
    seconds, fps = extent(track)
    length = seconds - track.start if length is None else length
    there = int(length * fps + 0.5)
    if there < frames:
        raise DataError(
            f"'{show(track.file)}' has {max(0, there)} pictures there, and {frames} were asked for."
        )

    def even(count: int) -> list[float]:
        return [(k + 0.5) * length / count for k in range(count)]

    if pick == "even":
        return even(frames)
    looks = even(max(frames, min(LOOKS, there)))
    small = [
        np.asarray(one.convert("L").resize((GRID, GRID), Image.Resampling.BOX), float)
        for one in pictures(track, looks)
    ]
    change = np.array(small) - small[0]
    off = np.abs(change - np.median(change, axis=(1, 2), keepdims=True)).max(axis=(1, 2))
    return [looks[k] for k in sorted(np.argsort(-off, kind="stable")[:frames])]


def plain(name: str) -> str:
    """Return a name as a folder.

    >>> plain("wood / oak"), plain("..")
    ('wood - oak', '-')
    """
    return re.sub(r"[^\w .()+-]+|^\.+", "-", name).strip()[:80] or "-"
