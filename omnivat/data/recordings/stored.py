"""Pairs whose pictures lie in files of other programs: Parquet with pictures as the package
`datasets` writes it, and arrays of pictures in HDF5, NPZ or safetensors, perhaps in groups.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from omnivat.data.class_labels import class_names, labelled_rows
from omnivat.data.columns import READERS, Columns, Pictures, columns_of
from omnivat.data.foreign import texts_in
from omnivat.data.materials import NO_CLASS, class_key
from omnivat.data.naming import (
    COLUMNS,
    cameras_among,
    checked_split,
    composed,
    is_file_name,
    set_name,
    split_of,
)
from omnivat.data.readers.files import TABLES, number_of, read_labels, show
from omnivat.data.recordings.groups import AFTER, Place, classes_of, tell
from omnivat.data.recordings.tracks import Clip, Frames, Track
from omnivat.kit.errors import DataError, SettingsError, printable

if TYPE_CHECKING:
    from PIL import Image

STORED = tuple(ending for ending in READERS if ending not in TABLES)
GROUPED = (".h5", ".hdf5", ".npz")  # in a folder, a file for each recording or class
LABELS = ("domain", "material", "object", "split")
PICTURES = "pictures"  # the camera of pictures whose names tell none
NAMED = 3  # recordings that a message names


class Column(NamedTuple):
    """One column of pictures: its file, name, pictures and place."""

    table: Columns
    name: str
    pictures: Pictures
    place: Place


@dataclass(slots=True)
class Recording:
    """The columns of one recording, or of one single picture of each camera."""

    columns: list[Column] = field(default_factory=list)
    texts: dict[str, list[str]] = field(default_factory=dict)  # a label for each row, or one
    origins: dict[str, str] = field(default_factory=dict)  # the array of each label
    problem: str = ""

    @property
    def place(self) -> Place:
        return self.columns[0].place

    @property
    def name(self) -> str:
        return "/".join(filter(None, (*self.place.units, self.place.shot)))


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
            Column(table, name, one, Place(names=(name,), still=False, camera=name))
            for name in table.names
            if (one := table.pictures_of(name))
        ]
        _require_pictures(found, [file])
        told = (file.stem.partition("-")[0], file.parent.name if file.parent != root else "")
        split = next(filter(None, map(split_of, told)), "")
        above = [p for p in file.relative_to(root).parent.parts if p != "data" and not split_of(p)]
        only = Recording(columns=found)
        only.place.split = split
        _labels(only, columns)
        _named_classes([only], classes, file)
        clips += _clips([only], vis, tac, domain, (*above,), root)
    return clips


def _require_pictures(found: Sequence[Column], files: Sequence[Path]) -> None:
    if not found:
        raise DataError(
            f"'{show(files[0])}' holds no pictures; of vectors, name their encoder with --encoder"
            " NAME."
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
    for one in made:
        _labels(one, columns)
    _from_lists(made)
    _from_masks(made)
    _from_table(made, labels)
    _from_names(made, columns, files[0])
    _named_classes(made, classes, files[0])
    if len(files) == 1:
        for one in made:
            one.place.split = one.place.split or split_of(files[0].stem)
    return _clips(made, vis, tac, domain, (), root)


def _labels(one: Recording, columns: Mapping[str, str]) -> None:
    """Note the labels that arrays and attributes near a recording give: one, or one a row."""
    column = one.columns[0]
    inner = column.name.split("/")[:-1]
    units = [k for k, part in enumerate(inner) if composed(part) in one.place.units]
    top = inner[: units[-1] + 1] if units else []  # arrays below are the recording's own
    table = column.table
    for label in LABELS:
        theirs = (columns[label],) if label in columns else (label, *COLUMNS.get(label, ()))
        for key in map(str.casefold, filter(None, theirs)):
            name = _array(table, key, inner, top)
            cell = table.get(name) if name else _attribute(table, key, column.name)
            if cell is None or (label not in columns and not _may_label(cell)):
                continue
            array = np.asarray(cell).reshape(-1) if np.size(cell) == 1 else np.asarray(cell)
            one.texts[label] = texts_in(array, label, len(array), table.place)
            one.origins[label] = f"{table.place}:{name}" if name else ""
            break
        else:
            if columns.get(label) and not one.place.units:
                raise DataError(
                    f"'{table.place}' has no column '{columns[label]}'; it has"
                    f" {', '.join(table.names)}."
                )


def _may_label(cell: Any) -> bool:
    """Return whether an array may hold labels: texts or whole numbers, one for each row."""
    array = np.asarray(cell)
    flat = array.ndim < 2 or array.shape[1:] == (1,)
    return flat and (array.dtype.kind != "f" or bool((array % 1 == 0)[np.isfinite(array)].all()))


def _array(table: Columns, key: str, inner: list[str], top: list[str]) -> str:
    """Return the array of a name that is nearest to a column: in its group or one above, or in
    its recording; "" without one.
    """
    near = []
    for name in table.names:
        parts = name.split("/")
        above = parts[:-1]
        mine = above == inner[: len(above)] or above[: len(top)] == top
        if mine and key in (parts[-1].casefold(), name.casefold()):
            near.append((sum(a == b for a, b in zip(above, inner, strict=False)), name))
    return max(near)[1] if near else ""


def _attribute(table: Columns, key: str, name: str) -> Any:
    """Return the attribute of a name of a column, or of the nearest group above it."""
    while True:
        for theirs, value in table.attributes(name).items():
            if theirs.casefold() == key and np.size(value) == 1:
                return value
        if not name:
            return None
        name = name.rpartition("/")[0]


def _from_lists(made: Sequence[Recording]) -> None:
    """Deal out an array that has a label for each of several recordings, numbered from 0; one of
    another length tells nothing about them.
    """
    of_many = Counter(origin for one in made for origin in one.origins.values() if origin)
    numbers = [number_of(Path(one.name)) for one in made]
    dealt = sorted(-1 if n is None else n for n in numbers) == [*range(len(made))]
    for one, number in zip(made, numbers, strict=True):
        for label, origin in one.origins.items():
            if of_many[origin] > 1 and (texts := one.texts[label])[1:]:
                fits = dealt and len(texts) == len(made)
                one.texts[label] = [texts[number or 0]] if fits else []
                if not fits:
                    del one.texts[label]


def _from_masks(made: Sequence[Recording]) -> None:
    """Take the splits of robomimic: arrays mask/train and mask/valid name recordings."""
    for table in {id(one.columns[0].table): one.columns[0].table for one in made}.values():
        for name in table.names:
            above, _, split = name.rpartition("/")
            if above.rpartition("/")[2] == "mask" and (split := split_of(split)):
                listed = {
                    *map(
                        composed, texts_in(array := table.read(name), name, len(array), table.place)
                    )
                }
                for one in made:
                    if one.columns[0].table is table and listed & {*one.place.units}:
                        one.texts.setdefault("split", [split])


def _from_table(made: Sequence[Recording], labels: Path | None) -> None:
    """Take the labels of a table whose column episode or file names recordings."""
    if labels is None:
        return
    if not any(one.place.units for one in made):
        raise SettingsError("--labels is for recordings; this file has one pair in each row.")
    try:
        table = read_labels(labels, "episode")
    except DataError:
        table = read_labels(labels, "file")
    rows = {Path(name).with_suffix("").as_posix(): row for name, row in table.items()}
    for one in made:
        units = "/".join(one.place.units)
        names = [units, *one.place.units[::-1], str(number_of(Path(units)))]
        names = [name for name in rows if f"/{name}".endswith(f"/{units}")] + names
        row = next((rows[name] for name in names if name in rows), None)
        if row is None:
            one.problem = "--labels does not list it."
        one.texts |= {name: [text] for name, text in (row or {}).items() if text and name in LABELS}


def _from_names(made: Sequence[Recording], columns: Mapping[str, str], file: Path) -> None:
    """Take classes, domains and objects from the names of groups, as far as nothing else gives
    them. Raises DataError for recordings whose class nothing tells.
    """
    named = "material" not in columns and not any("material" in one.texts for one in made)
    places = {one.place.units: one.place.counted for one in made}
    groups, domains = classes_of(places)
    words = {re.sub(r"\d+$", "", units[-1]) for units in places if units}
    for one in made:
        units, told = one.place.units, {*one.texts.get("domain", ())}
        if units in domains and not one.texts.get("domain"):
            one.texts["domain"] = [domains[units]]
            told.add(domains[units])
        if named and units in groups:
            one.texts["material"] = [groups[units]]
            told.add(groups[units])
        if units and not {*units} <= told and not any(one.texts.get("object", ())):
            split = one.place.split if len(words) < 2 else ""  # demo_0 of train is not that of test
            one.texts["object"] = ["/".join(filter(None, (split, *units)))]
    lost = [one for one in made if one.place.units and not one.texts.get("material")]
    if len(lost) == len(made) and "material" not in columns:
        more = ", …" if len(lost) > NAMED else ""
        attributes = dict.fromkeys(
            key
            for column in lost[0].columns[:1]
            for name in ("", *_groups(column.name), column.name)
            for key in column.table.attributes(name)
        )
        there = f" (there are {', '.join(attributes)})" if attributes else ""
        raise DataError(
            f"'{show(file)}' holds recordings, {printable(', '.join(o.name for o in lost[:NAMED]))}"
            f"{more}, and no class of them. Give a table of the columns episode and material with"
            f" --labels TABLE, or name an attribute or array with --column material=NAME{there};"
            " without classes, --column material= imports them."
        )


def _groups(name: str) -> Iterator[str]:
    parts = name.split("/")
    yield from ("/".join(parts[:k]) for k in range(1, len(parts)))


def _named_classes(made: Sequence[Recording], classes: Sequence[str], file: Path) -> None:
    """Give numbered classes their names, and rows without a class ""."""
    all = [(one, k) for one in made for k in range(len(one.texts.get("material", ())))]
    texts = [one.texts["material"][k] for one, k in all]
    kept = labelled_rows(texts)
    named = dict(
        zip(kept, class_names([texts[k] for k in kept], classes or None, file), strict=True)
    )
    for number, (one, k) in enumerate(all):
        one.texts["material"][k] = named.get(number, "")


def _clips(
    made: Sequence[Recording],
    vis: str,
    tac: Sequence[str],
    domain: str,
    above: Sequence[str],
    root: Path,
) -> list[Clip]:
    """Return the clips of recordings whose labels are known, for each camera of touches."""
    cameras = dict.fromkeys(c.place.camera or PICTURES for one in made for c in one.columns)
    full = {c.name: c.place.camera or PICTURES for one in made for c in one.columns}

    def meant(name: str) -> str:
        """Return the camera that a person named, perhaps without the groups above it."""
        ends = [camera for camera in cameras if camera.endswith(f"/{name}")]
        return full.get(name, ends[0] if len(ends) == 1 else name) if name not in cameras else name

    where = f"'{show(made[0].columns[0].table.place)}'"
    photo, touches, places = cameras_among([*cameras], meant(vis), [*map(meant, tac)], where)
    clips: list[Clip] = []
    for one in made:
        own: dict[str, Column] = {}
        for column in one.columns:
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
                clips += _of_one(one, own, halves, name or set_name(root.resolve()))
    return clips


def _of_one(
    one: Recording, own: Mapping[str, Column], halves: Mapping[str, str], domain: str
) -> Iterator[Clip]:
    """Yield the clips of a recording with one camera of photos and one of touches: itself if it is
    numbered, or else one for each row.
    """
    file = one.columns[0].table.place
    there = {half: own[name].pictures for half, name in halves.items() if name in own}
    lacking = [f"It has no pictures of '{show(n)}'." for n in halves.values() if n not in own]
    problem = one.problem or "".join(lacking[:1])
    rows = {half: pictures.rows for half, pictures in there.items() if pictures.rows}
    count = max(rows.values(), default=1)
    varying = any(len({*texts}) > 1 for texts in one.texts.values())
    film = any(one.place.counted) and bool(rows) and not varying
    if not film and len({*rows.values()}) > 1 and not problem:
        shown = " and ".join(
            f"{n} pictures in {own[halves[half]].name}" for half, n in rows.items()
        )
        raise DataError(f"'{show(file)}' has {shown}; a pair needs one of each.")
    cameras = f"photo {halves.get('vis', 'none')}, touch {halves.get('tac', 'none')}"
    if film and len({*rows.values()}) > 1:
        cameras += ", paired by share where their numbers differ"
    name = one.name or file.stem
    touch = there.get("tac") or there.get("vis")
    for k in range(1 if film or problem else count):
        texts = {label: _text(one, label, k, count, film) for label in LABELS}
        row = f"{name} {k:06d}" if (count > 1 and not film) or not one.name else name
        lists = bool(there) and any(pictures.lengths for pictures in there.values())
        most = 1 if touch is None else touch.lengths[k] if touch.lengths else 1
        read = partial(_film, file, there) if film else partial(_row, file, there, k)
        yield Clip(
            read=partial(_refused, problem) if problem else read,
            name=row,
            domain=texts["domain"] or domain,
            material=class_key(texts["material"]) or NO_CLASS,
            object=texts["object"] or (row if lists else ""),
            split=checked_split(texts["split"], f"'{show(file)}', row {k}") or one.place.split,
            cameras=cameras,
            frames=max(1, touch.rows if film and touch else most),
        )


def _text(one: Recording, label: str, row: int, count: int, film: bool) -> str:
    """Return a label of a row; raises DataError for other numbers of labels and pictures."""
    texts = one.texts.get(label) or [""]
    if len(texts) not in (1, count) and not film:
        raise DataError(
            f"'{show(one.columns[0].table.place)}' has {len(texts)} of {label}"
            f"{f' in {show(one.name)}' if one.name else ''}, and {count} rows of pictures."
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


def still(file: Path, picture: "Callable[[], Image.Image]") -> Track:
    """Return a single picture as a track."""
    return Frames(file=file, times=[0.0], picture=lambda _: picture())
