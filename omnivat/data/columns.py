"""Named columns in files of other programs: NPZ, Parquet, HDF5, safetensors, or a table of text.

Only the columns that are needed are opened, so others may hold anything. No code in a file is run.
"""

import sys
import zipfile
from collections import defaultdict
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from safetensors import deserialize, safe_open

from omnivat.data.hdf5 import arrays
from omnivat.data.images import MIN_SIDE, from_array, opened, read_image
from omnivat.data.named_columns import Columns, Pictures, explained, require_one, require_room
from omnivat.data.naming import FORMATS
from omnivat.data.parquet import parquet_columns
from omnivat.data.readers.files import TABLES, numbered_rows
from omnivat.kit.errors import DataError
from omnivat.kit.files import require_regular

if TYPE_CHECKING:
    from PIL import Image

COLOURS = (1, 3, 4)  # numbers of channels
TOLD = tuple(kind for kind in FORMATS if kind != "TGA")  # by their first bytes


def columns_of(place: Path) -> Columns:
    """Return the columns of a file; its ending gives the format.

    Raises DataError if it is missing, of another kind or unreadable, MissingPackageError if the
    package for it is not installed.
    """
    require_regular(place)
    reader = READERS.get(place.suffix.lower())
    if reader is None:
        raise DataError(f"'{place}' ends in '{place.suffix}'; there are {', '.join(READERS)}.")
    with explained(place):
        return reader(place)


def _of_array(array: Any, place: Path, name: str) -> Pictures | None:
    """Return the pictures in an array: one, (N, H, W), (N, H, W, C), (N, C, H, W), or lists of
    these; two axes are a picture in a group, or if the name ends in a number.
    """
    shape, what = array.shape, f"{place.name}, {name}"
    numbered, inner = name[-1:].isdigit(), "/" in name
    if array.dtype.kind not in "iuf" or (array.ndim < 3 and array.dtype.itemsize > 2):
        return None

    def is_picture(*axes: int) -> bool:
        sides = axes[:-1] if axes[-1] in COLOURS else axes[1:] if axes[0] in COLOURS else ()
        return min((axes if len(axes) == 2 else sides) or (0,)) >= MIN_SIDE

    alone = {2: numbered or inner, 3: shape[-1:] in [(c,) for c in COLOURS] or numbered}
    if alone.get(array.ndim) and is_picture(*shape):
        return Pictures(rows=0, one=lambda _, __: from_array(np.asarray(array[()]), what))
    if array.ndim in (3, 4) and is_picture(*shape[1:]):
        return Pictures(
            rows=len(array), one=lambda k, _: from_array(np.asarray(array[k]), f"{what}, row {k}")
        )
    if array.ndim in (4, 5) and is_picture(*shape[2:]):
        return Pictures(
            rows=len(array),
            one=lambda k, t: from_array(np.asarray(array[k, t]), f"{what}, row {k}, {t}"),
            lengths=[shape[1]] * len(array),
        )
    return None


def _npz(place: Path) -> Columns:
    if not zipfile.is_zipfile(place):
        raise DataError(f"'{place}' is not an NPZ file; write it with numpy.savez.")

    def read(name: str) -> NDArray[Any]:
        with np.load(place, allow_pickle=False) as found:
            try:
                array = np.asarray(found[name])
            except ValueError as error:
                if not str(error).startswith("Object arrays"):
                    raise
                raise DataError(
                    f"'{place}' holds pickled objects in {name}, which are not read; save one array"
                    " of numbers, or of str."
                ) from error
        texts = array.tobytes() if array.dtype.kind == "U" else b""
        letters = np.frombuffer(texts, np.dtype("u4").newbyteorder(array.dtype.byteorder))
        if letters.max(initial=0) > sys.maxunicode:
            raise DataError(f"'{place}' holds texts in {name} that are no Unicode; save it again.")
        return array

    with zipfile.ZipFile(place) as archive:
        stated = sum(member.file_size for member in archive.infolist())
    require_room(place, stated, "its arrays")
    with np.load(place, allow_pickle=False) as found:
        names = tuple(found.files)
    return Columns(
        place=place, names=names, read=read, pictures=lambda n: _of_array(read(n), place, n)
    )


def _safetensors(place: Path) -> Columns:
    def read(name: str) -> NDArray[Any]:
        with safe_open(place, framework="numpy") as file:
            if file.get_slice(name).get_dtype() != "BF16":  # which NumPy lacks
                return np.asarray(file.get_tensor(name))
        content = place.read_bytes()
        tensor = dict(deserialize(content))[name]  # type: ignore[no-untyped-call]
        upper = np.frombuffer(tensor["data"], "<u2").astype("<u4") << 16
        return upper.view("<f4").reshape(tensor["shape"])

    with safe_open(place, framework="numpy") as file:
        names = tuple(file.keys())
    return Columns(
        place=place, names=names, read=read, pictures=lambda n: _of_array(read(n), place, n)
    )


def _hdf5(place: Path) -> Columns:
    there, attributes = arrays(place)

    def pictures(name: str) -> Pictures | None:
        own = there[name]
        axes = own.ndim + (own.dtype.kind in "OV")
        rows = len(own) if axes == 2 else 0

        def encoded(k: int) -> bytes:
            return own[k if rows else ()].tobytes()

        def file_in(k: int, _: int) -> "Image.Image":
            return read_image(encoded(k), f"{place.name}, {name}, row {k}", reduced=False)

        if (own.of_bytes or own.dtype.kind == "V") and axes in (1, 2) and own.size:
            with suppress(DataError):
                opened(encoded(0), name, kinds=TOLD)
                return Pictures(rows=rows, one=file_in)
        return _of_array(own, place, name)

    return Columns(
        place=place,
        names=tuple(there),
        read=lambda name: there[name][()],
        pictures=pictures,
        attributes=lambda name: attributes.get(name, {}),
    )


def _text(place: Path) -> Columns:
    rows = numbered_rows(place)
    header = rows.pop(next(iter(rows), 0), [])
    for number, (line, row) in enumerate(rows.items()):
        if len(row) != len(header) and any(row[len(header) :] or row[-1:]):
            raise DataError(
                f"'{place}' has {len(row)} cells in row {number} (line {line}), and"
                f" {len(header)} in its first row."
            )
    cells = [row + [""] * (len(header) - len(row)) for row in rows.values()]

    places: dict[str, list[int]] = defaultdict(list)
    for at, title in enumerate(header):
        places[title].append(at)

    def read(name: str) -> NDArray[Any]:
        require_one(place, len(places[name]), name)
        return np.array([row[places[name][0]] for row in cells])

    return Columns(
        place=place, names=tuple(header), read=read, pictures=lambda name: None, lines=list(rows)
    )


READERS: dict[str, Callable[[Path], Columns]] = {
    ".npz": _npz,
    ".parquet": parquet_columns,
    ".h5": _hdf5,
    ".hdf5": _hdf5,
    ".safetensors": _safetensors,
    **dict.fromkeys(TABLES, _text),
}
