"""Read the weights of a TorchScript archive without compiling or running its code.

OpenAI publishes CLIP this way. An archive is a zip: `data.pkl` describes nested modules, each a
table of attributes, and `data/N` holds the values of tensor N. Only these are read here. The pickle
may use only listed names; any other name raises an error.
"""

import pickle
from collections import OrderedDict
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from zipfile import ZipFile, is_zipfile

import torch
from torch import Tensor

_KINDS = {
    "Double": "float64", "Float": "float32", "Half": "float16", "BFloat16": "bfloat16", "Long": "int64",
    "Int": "int32", "Short": "int16", "Char": "int8", "Byte": "uint8", "Bool": "bool",
}  # fmt: skip
STORAGES = {f"{name}Storage": getattr(torch, kind) for name, kind in _KINDS.items()}


def is_script(file: Path) -> bool:
    """True for a TorchScript archive, which contains weights and compiled code."""
    if not is_zipfile(file):
        return False
    with ZipFile(file) as archive:
        return any(name.endswith("/constants.pkl") for name in archive.namelist())


def read_script(file: Path) -> dict[str, Tensor]:
    """Return the parameters and buffers of a TorchScript archive under their dotted names.

    Raises pickle.UnpicklingError if the archive has anything but modules, tensors and numbers.
    """
    with ZipFile(file) as archive:
        inside = next(name for name in archive.namelist() if name.endswith("/data.pkl"))
        folder = inside.removesuffix("/data.pkl")
        with archive.open(inside) as handle:
            module = _Reader(handle, archive, folder).load()
    return dict(_tensors(module, ""))


class _Module:
    """A scripted module, read as the table of its attributes."""

    attributes: dict[str, Any]

    def __setstate__(self, state: Any) -> None:
        self.attributes = state if isinstance(state, dict) else {}


class _Reader(pickle.Unpickler):
    """Build modules, tensors and plain values; raise an error for any other class or function."""

    def __init__(self, handle: Any, archive: ZipFile, folder: str) -> None:
        super().__init__(handle)
        self._archive, self._folder = archive, folder
        self._numbers: dict[str, Tensor] = {}

    def find_class(self, module: str, name: str) -> Any:
        if module.startswith("__torch__"):
            return _Module
        if (module, name) == ("collections", "OrderedDict"):
            return OrderedDict
        if module == "torch._utils" and name in ("_rebuild_tensor_v2", "_rebuild_parameter"):
            return _tensor if name == "_rebuild_tensor_v2" else lambda tensor, *_: tensor
        if module == "torch" and name in STORAGES:
            return STORAGES[name]
        if module == "torch.jit._pickle" and name.startswith("build_"):
            return list
        raise pickle.UnpicklingError(f"the archive calls {module}.{name}")

    def persistent_load(self, pid: Any) -> Tensor:
        kind, dtype, key, *_ = pid
        if kind != "storage" or not isinstance(dtype, torch.dtype):
            raise pickle.UnpicklingError(f"the archive refers to {kind}")
        if key not in self._numbers:
            content = bytearray(self._archive.read(f"{self._folder}/data/{key}"))
            empty = torch.empty(0, dtype=dtype)
            self._numbers[key] = torch.frombuffer(content, dtype=dtype) if content else empty
        return self._numbers[key]


def _tensor(numbers: Tensor, offset: int, size: Any, stride: Any, *_: Any) -> Tensor:
    return numbers.as_strided(tuple(size), tuple(stride), offset).clone()


def _tensors(module: Any, prefix: str) -> Iterator[tuple[str, Tensor]]:
    for name, value in module.attributes.items():
        if isinstance(value, Tensor):
            yield prefix + name, value
        elif isinstance(value, _Module) and hasattr(value, "attributes"):
            yield from _tensors(value, f"{prefix}{name}.")
