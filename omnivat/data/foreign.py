"""Import embeddings from other programs: NPZ, Parquet, HDF5 or a CSV of vectors.

Each file has the vectors `vis` and `tac`, one row for each pair, and each pair's `material`. In NPZ
and HDF5 the vectors are arrays (N, D). In Parquet they are columns of lists, or numbered columns
`vis_0`, `vis_1`, ... as in a CSV. Optional columns: `domain`, `object`, `split`, `part`,
`looks_like`, `feels_like`, the file names `vis_file` and `tac_file`, and the mirrored vectors
`vis_flip` and `tac_flip`. No code in a file is run.
"""

import csv
import re
import zipfile
from collections.abc import Mapping, Sequence
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.arrays import require_range
from omnivat.data.embeddings import VECTORS, Array, Embeddings, Header, indices
from omnivat.data.materials import in_order
from omnivat.data.pairs import TEXTS
from omnivat.data.readers.files import encodable
from omnivat.data.store import ROW_NAMES
from omnivat.kit.errors import DataError, OmniVatError, first_line
from omnivat.kit.files import require_regular
from omnivat.kit.stages import IMAGES
from omnivat.kit.tables import need

PREFIX = "imported:"  # prefix of the encoder's name for imported embeddings
LABELS = ("domain", "material", *TEXTS)
FILES = ("vis_file", "tac_file")
SPLITS = ("train", "val", "test", "")
Columns = dict[str, NDArray[Any]]


def import_embeddings(
    file: str | Path,
    *,
    encoder: str,
    domain: str = "",
    material: str = "",
    classes: Sequence[str] = (),
    columns: Mapping[str, str] | None = None,
    preprocessing: str = "",
    origin: str = "",
    simulated: bool = False,
) -> Embeddings:
    """Return the embeddings in a file, checked and named.

    encoder         name of their encoder; files with the same name count as the same encoder
    domain          of all pairs, if the file has no such column
    material        of all pairs, if the file has no such column
    classes         names of the numbers in `material`, if it has numbers
    columns         name here -> name in the file, if they differ
    preprocessing   preprocessing of the images, if known
    origin          one line on the file's origin

    If the widths differ, the narrower vectors are padded with zeros.
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
    place = Path(file)
    table = read_columns(place)
    found = _named(table, columns or {}, place)
    for name in IMAGES:
        if name not in found:
            raise DataError(
                f"'{place}' has no vectors '{name}'; it has {', '.join(table) or 'nothing'}. Name"
                f" the right one with --column {name}=THEIRS."
            )
    count = len(found["vis"])
    mirrored = all(name in found for name in VECTORS)
    vectors = {
        name: _vectors(found[name], name, count, place)
        for name in (VECTORS if mirrored else IMAGES)
    }
    texts = {
        name: [text] * count for name, text in (("domain", domain), ("material", material)) if text
    }
    texts |= {name: _texts(found[name], name, count, place) for name in LABELS if name in found}
    _require_names(texts, place)
    texts["material"] = _materials(texts["material"], classes, place)
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
        origin=origin or f"imported from {place.name}",
    )
    return Embeddings(
        header=header,
        domain=indices(header.domains, texts["domain"]),
        label=indices(header.classes, texts["material"]),
        rows=_rows(found, texts, place),
        **{
            name: np.pad(array, ((0, 0), (0, max(widths.values()) - widths[name])))
            for name, array in vectors.items()
        },
    )


def _rows(columns: Columns, texts: Mapping[str, list[str]], place: Path) -> dict[str, list[str]]:
    """Return the named columns; files and objects without a name have the row's number."""
    count = len(texts["material"])
    rows = {name: texts.get(name, [""] * count) for name in ROW_NAMES}
    for name in IMAGES:
        numbered = np.array([f"{place.stem}/{row}_{name}" for row in range(count)])
        rows[name] = _texts(columns.get(f"{name}_file", numbered), f"{name}_file", count, place)
    if not any(rows["object"]):
        rows["object"] = [f"{place.stem}/{row}" for row in range(count)]
    return rows


def _named(table: Columns, columns: Mapping[str, str], place: Path) -> Columns:
    """Return the columns under the names used here, `columns` being their names in the file."""
    known = (*VECTORS, *LABELS, *FILES)
    for ours, theirs in columns.items():
        if ours not in known:
            raise DataError(
                f"There is no column '{ours}' to fill; there are {', '.join(sorted(known))}."
            )
        if _column(table, theirs, place) is None:
            raise DataError(f"'{place}' has no column '{theirs}'; it has {', '.join(table)}.")
    named = {name: _column(table, columns.get(name, name), place) for name in known}
    for other in ("class", "label"):
        if named["material"] is None:
            named["material"] = table.get(other)
    return {name: array for name, array in named.items() if array is not None}


def _column(table: Columns, name: str, place: Path) -> NDArray[Any] | None:
    """Return a column, or `name_0`, `name_1`, ... as one array (N, D); None if there is neither."""
    if name in table:
        return table[name]
    numbers = sorted(
        int(key[len(name) + 1 :]) for key in table if re.fullmatch(rf"{re.escape(name)}_\d+", key)
    )
    if not numbers:
        return None
    if numbers != list(range(numbers[0], numbers[0] + len(numbers))):
        raise DataError(
            f"'{place}' lacks some of the columns {name}_{numbers[0]} to {name}_{numbers[-1]}."
        )
    return np.stack([table[f"{name}_{i}"] for i in numbers], axis=1)


def _vectors(array: NDArray[Any], name: str, count: int, place: Path) -> Array:
    if array.ndim != 2 or len(array) != count or not array.size:
        raise DataError(
            f"'{place}' has {name} of shape {array.shape}, expected ({count}, D): a row of numbers"
            f" for each pair. Of pictures, make them with `python -m omnivat embed {place} --out"
            " SET.safetensors`."
        )
    try:
        with np.errstate(over="ignore"):
            values = array.astype(np.float64).astype(np.float32)
    except ValueError as error:
        raise DataError(f"'{place}' has no numbers in {name} ({error}).") from error
    (checked,) = require_range([values], f"{name} of '{place}'")
    return checked


def _texts(array: NDArray[Any], name: str, count: int, place: Path) -> list[str]:
    if array.shape != (count,):
        raise DataError(
            f"'{place}' has {name} of shape {array.shape}, expected ({count},): one for each pair."
        )
    texts = [
        value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
        for value in array.tolist()
    ]
    return [encodable(text, f"{name} in row {row} of '{place}'") for row, text in enumerate(texts)]


def _require_names(texts: Mapping[str, list[str]], place: Path) -> None:
    for name, option in (("material", "--column material=THEIRS"), ("domain", "--domain NAME")):
        if name not in texts:
            raise DataError(f"'{place}' has no column '{name}'; pass {option}.")
        if not all(text.strip() for text in texts[name]):
            raise DataError(f"'{place}' has pairs without a {name}; fill that column.")
    if unknown := sorted(set(texts.get("split", ())) - set(SPLITS)):
        raise DataError(
            f"'{place}' has the split '{unknown[0]}'; there are train, val, test and none."
        )


def _materials(texts: list[str], classes: Sequence[str], place: Path) -> list[str]:
    """Return class names; numbers are looked up in `classes`."""
    if not all(re.fullmatch(r"\d+", text) for text in texts):
        return texts
    highest = max(map(int, texts))
    if highest >= len(classes):
        raise DataError(
            f"'{place}' numbers its materials 0 to {highest}; name them with --classes "
            f"NAME,NAME,... ({len(classes)} came)."
        )
    return [classes[int(text)] for text in texts]


def read_columns(place: Path) -> Columns:
    """Return the named arrays of a file; its ending gives the format.

    Raises DataError if it is missing, of another kind or unreadable, MissingPackageError if the
    package for it is not installed.
    """
    require_regular(place)
    reader = READERS.get(place.suffix.lower())
    if reader is None:
        raise DataError(f"'{place}' ends in '{place.suffix}'; there are {', '.join(READERS)}.")
    try:
        return reader(place)
    except OmniVatError:
        raise
    except Exception as error:  # each reader has its own errors for damaged files
        raise DataError(
            f"'{place}' cannot be read ({first_line(error)}); export it again."
        ) from error


def _npz(place: Path) -> Columns:
    if not zipfile.is_zipfile(place):
        raise DataError(f"'{place}' is not an NPZ file; write it with numpy.savez.")
    with np.load(place, allow_pickle=False) as arrays:
        try:
            return {name: arrays[name] for name in arrays.files}
        except ValueError as error:
            raise DataError(
                f"'{place}' holds pickled objects, which are not read; save text as arrays of str."
            ) from error


def _parquet(place: Path) -> Columns:
    parquet = need("pyarrow.parquet", purpose="reading Parquet", install="pyarrow")
    table = parquet.read_table(place)
    found: Columns = {}
    for name, column in zip(table.column_names, table.columns, strict=True):
        rows = column.to_pylist()
        found[name] = np.array(["" if value is None else value for value in rows])
    return found


def _hdf5(place: Path) -> Columns:
    h5py = need("h5py", purpose="reading HDF5")
    with h5py.File(place, "r") as file:
        return {
            name: dataset.asstr()[()].astype(str) if dataset.dtype.kind == "O" else dataset[()]
            for name, dataset in file.items()
            if hasattr(dataset, "dtype")
        }


def _csv(place: Path) -> Columns:
    with place.open(newline="", encoding="utf-8-sig") as handle:
        names, *body = csv.reader(handle)
    if {len(row) for row in body} != {len(names)}:
        raise DataError(f"'{place}' should have rows of {len(names)} cells below its first row.")
    return {
        name: np.array(column) for name, column in zip(names, zip(*body, strict=True), strict=True)
    }


READERS = {".npz": _npz, ".parquet": _parquet, ".h5": _hdf5, ".hdf5": _hdf5, ".csv": _csv}
