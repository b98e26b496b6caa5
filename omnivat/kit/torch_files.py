"""Find the tensors in a PyTorch file: archives, TorchScript, and what PyTorch before 1.6 wrote.

Only the description is read, as data and in a limited process; no class of the file is needed.
"""

import struct
from collections.abc import Iterator
from operator import index
from pathlib import Path
from typing import IO, Any
from zipfile import ZIP_STORED, ZipFile, is_zipfile

from omnivat.kit.errors import DataError, first_line
from omnivat.kit.limited import Limited
from omnivat.kit.pickles import LIMITS, Inert, Reader

NESTED = ("_parameters", "_buffers", "_modules")  # tables of a module, which names leave out
CALLED = ("_rebuild_parameter", "_rebuild_parameter_with_state")  # with a tensor first
BYTES = {"Double": 8, "Float": 4, "Half": 2, "BFloat16": 2, "Long": 8, "Int": 4, "Short": 2}
BYTES |= {"ComplexDouble": 16, "ComplexFloat": 8, "Char": 1, "Byte": 1, "Bool": 1}
DEPTH = 50  # deeper than any model: a circle
Found = tuple[Any, dict[str, tuple[str, int, int]]]


def tensors(_: bytes, *, file: str) -> tuple[dict[str, Any], bytes]:
    """Return the tensors of a PyTorch file, and where their values are.

    "tensors": dotted name -> [storage, offset, size, stride]; names of mappings, modules and
    attributes are joined by dots. "storages": name -> [kind, first byte in the file, bytes].
    Raises DataError for a damaged file.
    """
    try:
        with Path(file).open("rb") as handle:
            root, storages = (_archived if is_zipfile(file) else _old)(handle)
        return {"tensors": dict(_named(root, "", 0)), "storages": storages}, b""
    except Exception as error:  # a damaged file raises any error
        raise DataError(f"its tensors cannot be read: {first_line(error)}") from error


def _archived(handle: IO[bytes]) -> Found:
    """Read an archive: `data.pkl` describes the tensors, and `data/N` is storage N."""
    with ZipFile(handle) as archive:
        members = {member.filename: member for member in archive.infolist()}
        inside = next(name for name in members if name.endswith("/data.pkl"))
        with archive.open(inside) as description:
            reader = Reader(description)
            root = reader.load()
    storages = {}
    for key, kind in reader.storages.items():
        member = members[f"{inside.removesuffix('.pkl')}/{key}"]
        if member.compress_type != ZIP_STORED:
            raise DataError("its values are compressed")
        handle.seek(member.header_offset + 26)
        names = sum(struct.unpack("<HH", handle.read(4)))
        storages[key] = kind, member.header_offset + 30 + names, member.file_size
    return root, storages


def _old(handle: IO[bytes]) -> Found:
    """Read pickles of three versions, the description and the storages' keys; values follow."""
    readers = [Reader(handle) for _ in range(5)]
    *_, root, keys = [reader.load() for reader in readers]
    storages = {}
    for key in keys:
        kind = readers[3].storages[key]
        size = int.from_bytes(handle.read(8), "little") * BYTES[kind.removesuffix("Storage")]
        storages[key] = kind, handle.tell(), size
        handle.seek(size, 1)
    return root, storages


def _named(value: Any, name: str, depth: int) -> Iterator[tuple[str, list[Any]]]:
    """Yield the tensors of a pickled value: its dotted name and [storage, offset, size, stride]."""
    called = value.name if isinstance(value, Inert) else ""
    if called.endswith(CALLED):
        yield from _named(value.arguments[0], name, depth)
    elif called.endswith("._rebuild_tensor_v2"):
        key, offset, *axes = value.arguments[:4]
        plain = (axis.arguments[0] if isinstance(axis, Inert) else axis for axis in axes)
        yield name, [key, index(offset), *([*map(index, axis)] for axis in plain)]
    elif depth < DEPTH:
        own = (value.state, value.items) if isinstance(value, Inert) else (value,)
        for key, part in (
            pair for record in own if isinstance(record, dict) for pair in record.items()
        ):
            if isinstance(key, str):
                longer = name if key in NESTED else f"{name}.{key}" if name else key
                yield from _named(part, longer, depth + 1)


read_tensors = Limited(f"{__name__}:tensors", **LIMITS)
