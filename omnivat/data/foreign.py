"""Import embeddings from other programs: NPZ, Parquet, HDF5, safetensors or a table of vectors.

Each file has the vectors `vis` and `tac`, or one of them, one row for each pair, and each pair's
`material`. In NPZ, HDF5 and safetensors the vectors are arrays (N, D). In Parquet they are columns
of lists, or numbered columns `vis_0`, `vis_1`, ... as in a CSV. Optional columns: `domain`,
`object`, `split`, `part`, `looks_like`, `feels_like`, the file names `vis_file` and `tac_file`, and
the mirrored vectors `vis_flip` and `tac_flip`. No code in a file is run.
"""

import re
from collections.abc import Mapping, Sequence
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.arrays import require_range, walked
from omnivat.data.class_labels import class_names, labelled_rows
from omnivat.data.columns import columns_of
from omnivat.data.embeddings import VECTORS, Array, Embeddings, Header, indices
from omnivat.data.materials import in_order
from omnivat.data.named_columns import Columns, require_room
from omnivat.data.naming import COLUMNS, checked_split, composed, half_of, is_image_name
from omnivat.data.numbers import numbers_of
from omnivat.data.pairs import TEXTS
from omnivat.data.readers.files import TABLES, encodable
from omnivat.data.store import ROW_NAMES
from omnivat.kit.errors import DataError, printable
from omnivat.kit.files import path_of
from omnivat.kit.stages import IMAGES

PREFIX = "imported:"  # prefix of the encoder's name for imported embeddings
LABELS = ("domain", "material", *TEXTS)
FILES = ("vis_file", "tac_file")
NAMED = 5  # rows that a message names
PAIR_BYTES = 500  # of memory for a pair's texts


def import_embeddings(
    file: str | Path,
    *,
    encoder: str,
    domain: str = "",
    material: str = "",
    classes: Sequence[str] | None = (),
    columns: Mapping[str, str] | None = None,
    preprocessing: str = "",
    origin: str = "",
    simulated: bool = False,
    numbers: Sequence[str] = (),
) -> Embeddings:
    """Return the embeddings in a file, checked and named.

    encoder         name of their encoder; files with the same name count as the same encoder
    domain          of all pairs, if the file has no such column
    material        of all pairs, if the file has no such column
    classes         names of the numbers in `material`, if it has numbers; None: "class 0", ...
    columns         name here -> name in the file, if they differ
    preprocessing   preprocessing of the images, if known
    origin          one line on the file's origin
    numbers         columns of numbers to keep, such as a force

    Without columns `vis` or `tac`, one whose words tell is taken, and the origin names it. If the
    widths differ, the narrower vectors are padded with zeros. Of vectors of one modality,
    each stands for both. Pairs without a class, a blank or a negative number, are left out, and the
    origin names them.
    Raises DataError, one sentence with the file and the fault.

    >>> from tempfile import TemporaryDirectory
    >>> vectors, material = np.eye(4, dtype=np.float32), ["wood", "wood", "steel", "steel"]
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "mine.npz"
    ...     np.savez(file, vis=vectors, touch=vectors, material=material)
    ...     mine = import_embeddings(file, encoder="mine", domain="A", columns={"tac": "touch"})
    >>> len(mine), mine.header.encoder, mine.header.classes
    (4, 'imported:mine', ('wood', 'steel'))
    """
    place = path_of(file)
    table = columns_of(place)
    named = _named_by_words(table, columns or {})
    found = named_columns(table, named)
    there = tuple(name for name in IMAGES if name in found)
    if not there:
        raise DataError(
            f"'{place}' has no vectors 'vis' or 'tac'; it has"
            f" {', '.join(table.names) or 'nothing'}. Name the right ones with --column vis=THEIRS."
        )
    count = len(np.atleast_1d(found[there[0]]))  # a single number is refused with the others
    mirrored = all(f"{name}_flip" in found for name in there)
    made = sum(4 * np.size(found[name]) for name in VECTORS if name in found)
    require_room(place, made + PAIR_BYTES * count, "its vectors and names")
    vectors = {
        name: _vectors(found.pop(name), name, count, table)
        for name in (*there, *(f"{name}_flip" for name in there if mirrored))
    }
    texts = {
        name: [text] * count for name, text in (("domain", domain), ("material", material)) if text
    }
    texts |= {name: texts_in(found[name], name, count, place) for name in LABELS if name in found}
    kept = _require_names(texts, table)
    texts["split"] = [
        checked_split(text, f"'{place}', {table.row(row)}")
        for row, text in enumerate(texts.get("split", [""] * count))
    ]
    texts["material"] = class_names([texts["material"][k] for k in kept], classes, place)
    texts |= {name: [all[k] for k in kept] for name, all in texts.items() if name != "material"}
    words = "".join(f"; {name} is '{named[name]}'" for name in IMAGES if name in named)
    left_out = f"; {left_out_rows(kept, count, table)}" if len(kept) < count else ""
    widths = {name: array.shape[1] for name, array in vectors.items()}
    padded = (
        f" ({', '.join(f'{name} {width}' for name, width in widths.items())} values, then zeros)"
    )
    header = Header(
        encoder=PREFIX + encoder.strip(),
        weights_hash=blake2b(encoder.strip().encode(), digest_size=8).hexdigest(),
        preprocessing=(preprocessing or "made elsewhere")
        + (padded if len(set(widths.values())) > 1 else ""),
        domains=tuple(dict.fromkeys(texts["domain"])),
        classes=in_order(set(texts["material"])),
        simulated=simulated,
        origin=(origin or f"imported from {place.name}") + words + left_out,
        modalities=there,
    )
    whole = len(kept), max(widths.values())
    arrays = {
        name: array
        if array.shape == whole
        else np.pad(array, ((0, 0), (0, whole[1] - widths[name])))[kept]
        for name, array in vectors.items()
    }
    for name in VECTORS:  # of one modality, it stands for both
        alone = name.replace("vis", there[0]).replace("tac", there[-1])
        if alone in arrays:
            arrays.setdefault(name, arrays[alone])
    return Embeddings(
        header=header,
        domain=indices(header.domains, texts["domain"]),
        label=indices(header.classes, texts["material"]),
        rows=_rows(found, texts, kept, place) | numbers_of(table, numbers, kept, count),
        **arrays,
    )


def left_out_rows(kept: Sequence[int], count: int, table: Columns) -> str:
    """Return which rows have no class, for people."""
    lost = sorted({*range(count)} - {*kept})
    more = f" and {len(lost) - NAMED} more" if len(lost) > NAMED else ""
    return (
        f"{len(lost)} of {count} rows left out, which have no class:"
        f" {', '.join(map(table.row, lost[:NAMED]))}{more}"
    )


def _rows(
    columns: Mapping[str, NDArray[Any]],
    texts: Mapping[str, list[str]],
    kept: Sequence[int],
    place: Path,
) -> dict[str, list[str]]:
    """Return the named columns; files and objects without a name have the row's number."""
    rows = {name: texts.get(name, [""] * len(kept)) for name in ROW_NAMES}
    for name in IMAGES:
        key = f"{name}_file"
        files = texts_in(columns[key], key, len(columns[key]), place) if key in columns else []
        rows[name] = [files[k] if files else f"{place.stem}/{k}_{name}" for k in kept]
    if not any(rows["object"]):
        rows["object"] = [f"{place.stem}/{k}" for k in kept]
    return rows


def _named_by_words(table: Columns, columns: Mapping[str, str]) -> dict[str, str]:
    """Return the names of columns, with those of photos and touches that only their words tell.

    Raises DataError if words tell of several.
    """
    named = dict(columns)
    stems = dict.fromkeys(re.sub(r"_\d+$", "", name) for name in table.names)
    others = [name for name in stems if name not in (*VECTORS, *FILES, *named.values())]
    for half in IMAGES:
        candidates = [name for name in others if half_of(name) == half]
        if half in named or half in stems or table.path(half) or not candidates:
            continue
        if len(candidates) > 1:
            _require_vectors(table, next(iter(candidates)))
            raise DataError(
                f"'{table.place}' has {', '.join(candidates)};"
                f" name one with --column {half}=THEIRS."
            )
        named[half] = candidates[0]
    return named


def named_columns(table: Columns, columns: Mapping[str, str]) -> dict[str, NDArray[Any]]:
    """Return the columns under the names used here, `columns` being their names in the file.

    Raises DataError for a name that is not there, and for pictures in the place of vectors.
    """
    known = (*VECTORS, *LABELS, *FILES)
    for ours, theirs in columns.items():
        if ours not in known:
            raise DataError(
                f"There is no column '{ours}' to fill; there are {', '.join(sorted(known))}."
            )
        if not table.path(theirs) and table.get(theirs) is None:
            raise DataError(
                f"'{table.place}' has no column '{theirs}'; it has {', '.join(table.names)}."
            )
    found = {}
    for name in known:
        theirs = columns.get(name, name)
        others = () if name in columns else COLUMNS.get(name, ())
        path = next((p for p in map(table.path, (theirs, *others)) if p), theirs)
        if name in VECTORS and table.path(path):
            _require_vectors(table, path)
        if (array := table.get(path)) is not None:
            found[name] = array
    return found


def _require_vectors(table: Columns, name: str) -> None:
    if table.path(name) and table.pictures_of(name):
        raise DataError(
            f"'{table.place}' holds pictures in {name}, and not vectors: make a folder of pairs"
            f" with `python -m omnivat import {table.place} --out PAIRS`, without --encoder."
        )


def _vectors(array: NDArray[Any], name: str, count: int, table: Columns) -> Array:
    if array.ndim == 1 and array.size and is_image_name(str(array[0])):
        csv = table.place.with_suffix(".csv") if table.place.suffix not in TABLES else table.place
        made = "" if csv == table.place else f" save its columns as {csv}, and"
        raise DataError(
            f"'{table.place}' names pictures in {name}, and not vectors;{made} make them with"
            f" `python -m omnivat embed {csv} --out SET.safetensors`."
        )
    if array.ndim != 2 or len(array) != count or not array.size:
        raise DataError(
            f"'{table.place}' has {name} of shape {array.shape}, expected ({count}, D): a row of"
            " numbers for each pair."
        )
    if array.dtype.kind == "c":
        raise DataError(f"'{table.place}' has complex numbers in {name}; save real ones.")
    try:
        with np.errstate(over="ignore"):
            values = np.require(array, np.float32, ["C", "W"])
    except ValueError:
        values = np.array([_numbers(row, name, k, table) for k, row in enumerate(array)], "f4")
    finite = np.isfinite(values)
    if not finite.all():
        row, at = divmod(int(finite.argmin()), finite.shape[1])
        raise DataError(
            f"'{table.place}' has {values[row, at]} in {name}, {table.row(row)}; leave that row"
            " out, or compute it again."
        )
    for _ in require_range(walked(values), f"{name} of '{table.place}'"):
        pass
    return values


def _numbers(cells: NDArray[Any], name: str, row: int, table: Columns) -> list[float]:
    """Return the numbers in a row of texts, which may have decimal commas."""
    found = []
    for cell in map(str, cells):
        try:
            found.append(float(cell.replace(",", ".")))
        except ValueError as error:
            text = f"'{printable(cell[:40])}'" if cell.strip() else "an empty cell"
            raise DataError(
                f"'{table.place}' has no numbers in {name}, {table.row(row)}: {text}."
            ) from error
    return found


def texts_in(array: NDArray[Any], name: str, count: int, place: Path) -> list[str]:
    """Return a column of texts; raises DataError for another shape and for texts that no file can
    hold.
    """
    if array.shape == (count, 1):
        array = array[:, 0]
    if array.shape != (count,):
        raise DataError(
            f"'{place}' has {name} of shape {array.shape}, expected ({count},): one for each pair."
        )
    texts = [
        value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
        for value in array.tolist()
    ]
    return [
        composed(encodable(text, f"{name} in row {row} of '{place}'"))
        for row, text in enumerate(texts)
    ]


def _require_names(texts: Mapping[str, list[str]], table: Columns) -> list[int]:
    """Return the rows that have a class; raises DataError if a column or a domain is missing."""
    for name, option in (("material", "--column material=THEIRS"), ("domain", "--domain NAME")):
        if name not in texts:
            raise DataError(f"'{table.place}' has no column '{name}'; pass {option}.")
    for row, text in enumerate(texts["domain"]):
        if not text.strip():
            raise DataError(f"'{table.place}' has no domain in {table.row(row)}; fill that column.")
    kept = labelled_rows(texts["material"])
    if not kept:
        raise DataError(f"'{table.place}' has no material in any row; fill that column.")
    return kept
