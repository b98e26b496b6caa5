"""Read the arrays of an NPZ file whose maker is unknown."""

from io import BytesIO
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from omnivat.kit.errors import DataError, first_line
from omnivat.kit.files import require_regular

HEADERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}


def read_npz(file: Path, most: int) -> dict[str, NDArray[Any]]:
    """Return the arrays of an NPZ file by name.

    most  bytes of all arrays: a small file may unpack to any size

    Raises DataError for a damaged file, pickled objects, and an array that states another shape
    than its bytes fill.
    """
    require_regular(file)
    try:
        with ZipFile(file) as archive:
            if sum(member.file_size for member in archive.infolist()) > most:
                raise ValueError(f"its arrays have over {most / 1e6:.0f} MB")
            names = archive.namelist()
            return {name.removesuffix(".npy"): _array(archive.read(name)) for name in names}
    except Exception as error:  # a damaged archive raises any error
        raise DataError(f"'{file}' cannot be read as NPZ ({first_line(error)}).") from error


def _array(content: bytes) -> NDArray[Any]:
    handle = BytesIO(content)
    shape, fortran, dtype = HEADERS[npy.read_magic(handle)](handle)
    if dtype.hasobject:
        raise ValueError("it holds pickled objects")
    flat = np.frombuffer(content, dtype, offset=handle.tell())
    return flat.reshape(shape, order="F" if fortran else "C").copy()
