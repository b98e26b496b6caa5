"""The labels of pictures in files: of arrays and attributes near them, of a table, of the names of
groups.
"""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from omnivat.data.class_labels import class_names, labelled_rows
from omnivat.data.foreign import texts_in
from omnivat.data.named_columns import Columns, Pictures
from omnivat.data.naming import COLUMNS, composed, split_of
from omnivat.data.readers.files import number_of, numbered_rows, read_labels, show
from omnivat.data.recordings.groups import Place, classes_of
from omnivat.kit.errors import DataError, SettingsError, printable

LABELS = ("domain", "material", "object", "split")
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


def near_labels(recording: Recording, columns: Mapping[str, str]) -> None:
    """Note the labels that arrays and attributes near a recording give: one, or one a row."""
    column = recording.columns[0]
    inner = column.name.split("/")[:-1]
    units = [k for k, part in enumerate(inner) if composed(part) in recording.place.units]
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
            recording.texts[label] = texts_in(array, label, len(array), table.place)
            recording.origins[label] = f"{table.place}:{name}" if name else ""
            break
        else:
            if columns.get(label) and not recording.place.units:
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
    for name in table.alike(key):
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


def from_lists(made: Sequence[Recording]) -> None:
    """Deal out an array that has a label for each of several recordings, numbered from 0; one of
    another length tells nothing about them.
    """
    of_many = Counter(
        origin for recording in made for origin in recording.origins.values() if origin
    )
    numbers = [number_of(Path(recording.name)) for recording in made]
    dealt = sorted(-1 if n is None else n for n in numbers) == [*range(len(made))]
    for recording, number in zip(made, numbers, strict=True):
        for label, origin in recording.origins.items():
            if of_many[origin] > 1 and (texts := recording.texts[label])[1:]:
                fits = dealt and len(texts) == len(made)
                recording.texts[label] = [texts[number or 0]] if fits else []
                if not fits:
                    del recording.texts[label]


def from_masks(made: Sequence[Recording]) -> None:
    """Take the splits of robomimic: arrays mask/train and mask/valid name recordings."""
    for table in {
        id(recording.columns[0].table): recording.columns[0].table for recording in made
    }.values():
        for name in table.names:
            above, _, split = name.rpartition("/")
            if above.rpartition("/")[2] == "mask" and (split := split_of(split)):
                listed = {
                    *map(
                        composed, texts_in(array := table.read(name), name, len(array), table.place)
                    )
                }
                for recording in made:
                    if recording.columns[0].table is table and listed & {*recording.place.units}:
                        recording.texts.setdefault("split", [split])


def from_table(made: Sequence[Recording], labels: Path | None) -> None:
    """Take the labels of a table whose column episode or file names recordings."""
    if labels is None:
        return
    if not any(recording.place.units for recording in made):
        raise SettingsError("--labels is for recordings; this file has one pair in each row.")
    header = map(str.lower, next(iter(numbered_rows(labels).values()), []))
    table = read_labels(labels, "file" if "file" in header else "episode")
    rows = {Path(name).with_suffix("").as_posix(): row for name, row in table.items()}
    for recording in made:
        units = "/".join(recording.place.units)
        names = [units, *recording.place.units[::-1], str(number_of(Path(units)))]
        names = [name for name in rows if f"/{name}".endswith(f"/{units}")] + names
        row = next((rows[name] for name in names if name in rows), None)
        if row is None:
            recording.problem = "--labels does not list it."
        recording.texts |= {
            name: [text] for name, text in (row or {}).items() if text and name in LABELS
        }


def from_names(made: Sequence[Recording], columns: Mapping[str, str], file: Path) -> None:
    """Take classes, domains and objects from the names of groups, as far as nothing else gives
    them. Raises DataError for recordings whose class nothing tells.
    """
    named = "material" not in columns and not any(
        "material" in recording.texts for recording in made
    )
    places = {recording.place.units: recording.place.counted for recording in made}
    groups, domains = classes_of(places)
    words = {re.sub(r"\d+$", "", units[-1]) for units in places if units}
    for recording in made:
        units, stated = recording.place.units, {*recording.texts.get("domain", ())}
        if units in domains and not recording.texts.get("domain"):
            recording.texts["domain"] = [domains[units]]
            stated.add(domains[units])
        if named and units in groups:
            recording.texts["material"] = [groups[units]]
            stated.add(groups[units])
        if units and not {*units} <= stated and not any(recording.texts.get("object", ())):
            # demo_0 of train is not that of test
            split = recording.place.split if len(words) < 2 else ""
            recording.texts["object"] = ["/".join(filter(None, (split, *units)))]
    lost = [
        recording
        for recording in made
        if recording.place.units and not recording.texts.get("material")
    ]
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


def named_classes(made: Sequence[Recording], classes: Sequence[str], file: Path) -> None:
    """Give numbered classes their names, and rows without a class ""."""
    all = [
        (recording, k)
        for recording in made
        for k in range(len(recording.texts.get("material", ())))
    ]
    texts = [recording.texts["material"][k] for recording, k in all]
    kept = labelled_rows(texts)
    named = dict(
        zip(kept, class_names([texts[k] for k in kept], classes or None, file), strict=True)
    )
    for number, (recording, k) in enumerate(all):
        recording.texts["material"][k] = named.get(number, "")
