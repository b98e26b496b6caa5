"""Pairs whose pictures lie in files of other programs: Parquet with pictures as the package
`datasets` writes it, and arrays of pictures in HDF5, NPZ or safetensors, perhaps in groups.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from omnivat.data.columns import READERS, columns_of
from omnivat.data.materials import NO_CLASS, class_key
from omnivat.data.named_columns import Pictures
from omnivat.data.naming import (
    cameras_among,
    checked_split,
    composed,
    is_file_name,
    set_name,
    split_of,
)
from omnivat.data.readers.files import TABLES, show
from omnivat.data.recordings.groups import AFTER, Place, tell
from omnivat.data.recordings.labels import (
    LABELS,
    Column,
    Recording,
    from_lists,
    from_masks,
    from_names,
    from_table,
    named_classes,
    near_labels,
)
from omnivat.data.recordings.tracks import Clip, Frames, Track
from omnivat.kit.errors import DataError, SettingsError

if TYPE_CHECKING:
    from PIL import Image

STORED = tuple(ending for ending in READERS if ending not in TABLES)
GROUPED = (".h5", ".hdf5", ".npz")  # in a folder, a file for each recording or class
MOST_ROWS = 1_000_000  # of an array, whose file may state any number
MOST_LOOKS = 100  # columns that are searched for names of pictures
PICTURES = "pictures"  # the camera of pictures whose names tell none


def stored_files(source: Path) -> list[Path]:
    """Return the file, or the files of a folder, in order: Parquet, or else HDF5 or NPZ where no
    pictures or films lie beside; [] for anything else.
    """
    if not source.is_dir():
        return [source] if source.suffix.lower() in STORED else []
    files = sorted(f for f in source.rglob("*") if not f.name.startswith("."))
    parquet = [f for f in files if f.suffix.lower() == ".parquet"]
    if parquet or any(is_file_name(f.name) or f.name == "pairs.csv" for f in files):
        return parquet
    return [f for f in files if f.suffix.lower() in GROUPED]


def stored_clips(
    source: Path,
    *,
    vis: str,
    tac: Sequence[str],
    domain: str,
    classes: Sequence[str],
    columns: Mapping[str, str],
    labels: Path | None = None,
) -> list[Clip]:
    """Return the recordings in a file or the files of a folder, or a pair for each row of pictures.

    Of Parquet, a folder above a file, but for "data" and splits, names the domain, and the file's
    name or its folder may tell the split. Of HDF5 and NPZ, groups, and the names of several files
    and their folders, are recordings if they end in a number, and classes if not; attributes and
    arrays of a group label what is in it.

    vis, tac  names of the columns or arrays of photos and touches; "" and (): by their words
    domain    of all pairs without one; "": the folder's name
    classes   names of numbered classes
    columns   name here -> name in the file, if they differ; "": no column
    labels    a table whose column episode or file names recordings
    Raises DataError if a file has no pictures, or if cameras or labels cannot be told.
    """
    root = source if source.is_dir() else source.parent
    clips: list[Clip] = []
    files = stored_files(source)
    if files[0].suffix.lower() != ".parquet":
        return _grouped(files, root, vis, tac, domain, classes, columns, labels)
    if labels:
        raise SettingsError("--labels is for recordings; Parquet has its labels in columns.")
    for file in files:
        table = columns_of(file)
        found = [
            Column(table, name, pictures, Place(names=(name,), still=False, camera=name))
            for name in table.names
            if (pictures := table.pictures_of(name))
        ]
        _require_pictures(found, [file])
        names = (file.stem.partition("-")[0], file.parent.name if file.parent != root else "")
        split = next(filter(None, map(split_of, names)), "")
        above = [p for p in file.relative_to(root).parent.parts if p != "data" and not split_of(p)]
        only = Recording(columns=found)
        only.place.split = split
        near_labels(only, columns)
        named_classes([only], classes, file)
        clips += _clips([only], vis, tac, domain, (*above,), root)
    return clips


def _require_pictures(found: Sequence[Column], files: Sequence[Path]) -> None:
    if found:
        return
    table = columns_of(files[0])
    for name in table.names[:MOST_LOOKS]:
        with suppress(DataError):
            cells = np.ravel(np.asarray(table.get(name)))
            if cells.size and is_file_name(str(cells[0])):
                raise SettingsError(
                    f"'{show(files[0])}' names pictures in {show(name)}, and holds none; save its"
                    f" columns as {show(files[0].with_suffix('.csv'))}, and import that."
                )
    raise DataError(
        f"'{show(files[0])}' holds no pictures; of vectors, name their encoder with --encoder NAME."
    )


def _grouped(
    files: Sequence[Path],
    root: Path,
    vis: str,
    tac: Sequence[str],
    domain: str,
    classes: Sequence[str],
    columns: Mapping[str, str],
    labels: Path | None,
) -> list[Clip]:
    """Return the recordings of HDF5, NPZ or safetensors."""
    found: list[Column] = []
    for file in files:
        table = columns_of(file)
        above = file.relative_to(root).with_suffix("").parts if len(files) > 1 else ()
        for name in table.names:
            parts = tuple(name.split("/"))
            if AFTER not in parts and (pictures := table.pictures_of(name)):
                place = Place(names=(*map(composed, above), *parts), still=not pictures.rows)
                found.append(Column(table, name, pictures, place))
    _require_pictures(found, files)
    given = [one for name in filter(None, (vis, *tac)) for one in (name, name.rpartition("/")[2])]
    tell([column.place for column in found], given)
    recordings: dict[tuple[str, ...], Recording] = defaultdict(Recording)
    for column in found:
        place = column.place
        recordings[place.split, *place.units, "/", place.shot].columns.append(column)
    made = [*recordings.values()]
    for recording in made:
        near_labels(recording, columns)
    from_lists(made)
    from_masks(made)
    from_table(made, labels)
    from_names(made, columns, files[0])
    named_classes(made, classes, files[0])
    if len(files) == 1:
        for recording in made:
            recording.place.split = recording.place.split or split_of(files[0].stem)
    return _clips(made, vis, tac, domain, (), root)


def _clips(
    made: Sequence[Recording],
    vis: str,
    tac: Sequence[str],
    domain: str,
    above: Sequence[str],
    root: Path,
) -> list[Clip]:
    """Return the clips of recordings whose labels are known, for each camera of touches."""
    cameras = dict.fromkeys(
        c.place.camera or PICTURES for recording in made for c in recording.columns
    )
    full = {c.name: c.place.camera or PICTURES for recording in made for c in recording.columns}

    def meant(name: str) -> str:
        """Return the camera that a person named, perhaps without the groups above it."""
        ends = [camera for camera in cameras if camera.endswith(f"/{name}")]
        return full.get(name, ends[0] if len(ends) == 1 else name) if name not in cameras else name

    where = f"'{show(made[0].columns[0].table.place)}'"
    photo, touches, places = cameras_among([*cameras], meant(vis), [*map(meant, tac)], where)
    clips: list[Clip] = []
    for recording in made:
        own: dict[str, Column] = {}
        for column in recording.columns:
            same = own.setdefault(column.place.camera or PICTURES, column)
            if same is not column:
                raise DataError(
                    f"{where} has two arrays of one camera in one recording, {show(same.name)} and"
                    f" {show(column.name)}; leave one out, or move it to another group."
                )
        there = [touch for touch in touches if touch in own] or touches[:1]
        for touch, place in zip(touches, places, strict=True):
            if touch in there:
                halves = {half: name for half, name in (("vis", photo), ("tac", touch)) if name}
                name = domain or " ".join(filter(None, (*above, place)))
                clips += _of_one(recording, own, halves, name or set_name(root.resolve()))
    return clips


def _of_one(
    recording: Recording, own: Mapping[str, Column], halves: Mapping[str, str], domain: str
) -> Iterator[Clip]:
    """Yield the clips of a recording with one camera of photos and one of touches: itself if it is
    numbered, or else one for each row.
    """
    file = recording.columns[0].table.place
    there = {half: own[name].pictures for half, name in halves.items() if name in own}
    lacking = [f"It has no pictures of '{show(n)}'." for n in halves.values() if n not in own]
    problem = recording.problem or "".join(lacking[:1])
    rows = {half: pictures.rows for half, pictures in there.items() if pictures.rows}
    count = max(rows.values(), default=1)
    if count > MOST_ROWS:
        raise DataError(
            f"'{show(file)}' states {count:,} pictures in one array, where {MOST_ROWS:,} are read;"
            " divide it into several files."
        )
    varying = any(len({*texts}) > 1 for texts in recording.texts.values())
    film = any(recording.place.counted) and bool(rows) and not varying
    if not film and len({*rows.values()}) > 1 and not problem:
        shown = " and ".join(
            f"{n} pictures in {own[halves[half]].name}" for half, n in rows.items()
        )
        raise DataError(f"'{show(file)}' has {shown}; a pair needs one of each.")
    cameras = f"photo {halves.get('vis', 'none')}, touch {halves.get('tac', 'none')}"
    if film and len({*rows.values()}) > 1:
        cameras += ", paired by share where their numbers differ"
    name = recording.name or file.stem
    touch = there.get("tac") or there.get("vis")
    for k in range(1 if film or problem else count):
        texts = {label: _text(recording, label, k, count, film) for label in LABELS}
        row = f"{name} {k:06d}" if (count > 1 and not film) or not recording.name else name
        lists = bool(there) and any(pictures.lengths for pictures in there.values())
        most = 1 if touch is None else touch.lengths[k] if touch.lengths else 1
        read = partial(_film, file, there) if film else partial(_row, file, there, k)
        yield Clip(
            read=partial(_refused, problem) if problem else read,
            name=row,
            domain=texts["domain"] or domain,
            material=class_key(texts["material"]) or NO_CLASS,
            object=texts["object"] or (row if lists else ""),
            split=checked_split(texts["split"], f"'{show(file)}', row {k}")
            or recording.place.split,
            cameras=cameras,
            frames=max(1, touch.rows if film and touch else most),
        )


def _text(recording: Recording, label: str, row: int, count: int, film: bool) -> str:
    """Return a label of a row; raises DataError for other numbers of labels and pictures."""
    texts = recording.texts.get(label) or [""]
    if len(texts) not in (1, count) and not film:
        raise DataError(
            f"'{show(recording.columns[0].table.place)}' has {len(texts)} of {label}"
            f"{f' in {show(recording.name)}' if recording.name else ''}, and {count} rows of"
            " pictures."
        )
    return texts[row if len(texts) == count else 0]


def _refused(why: str) -> tuple[dict[str, Track], None]:
    raise DataError(why)


def _film(file: Path, halves: Mapping[str, Pictures]) -> tuple[dict[str, Track], float]:
    """Return the tracks of a recording, whose rows are moments; each lasts one unit of time."""

    def picture(pictures: Pictures, moment: int) -> "Image.Image":
        return pictures.one(moment, 0)

    return {h: _track(file, max(1, p.rows), partial(picture, p)) for h, p in halves.items()}, 1.0


def _row(file: Path, halves: Mapping[str, Pictures], row: int) -> tuple[dict[str, Track], float]:
    """Return the tracks of a row, of which lists are films of one length."""
    if empty := [half for half, p in halves.items() if p.lengths and not p.lengths[row]]:
        raise DataError(f"Its list of {empty[0]} is empty.")
    return {
        half: _track(file, p.lengths[row] if p.lengths else 1, partial(p.one, row))
        for half, p in halves.items()
    }, 1.0


def _track(file: Path, count: int, picture: "Callable[[int], Image.Image]") -> Track:
    return Frames(file=file, times=[k / count for k in range(count)], picture=picture)
