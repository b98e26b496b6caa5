"""Read pickles as data: every class and function in them becomes an inert record of its name.

A pickle is a program. Here it builds plain values, and imports, calls and changes nothing. Reading
still costs memory and time without bounds, so others' files are read in a limited process.
"""

import pickle
from io import BytesIO
from math import prod
from operator import index
from typing import Any

from omnivat.kit.errors import DataError, first_line
from omnivat.kit.limited import Limited

LIMITS: dict[str, Any] = {"memory": 1_000_000_000, "seconds": 5, "wait": 60.0}


class Inert:
    """What a pickle calls or makes: its name and arguments, and its later state and items."""

    name = ""

    def __new__(cls, *arguments: Any, **_: Any) -> "Inert":
        made = super().__new__(cls)
        made.arguments, made.state, made.items = arguments, None, {}
        return made

    arguments: tuple[Any, ...]
    state: Any
    items: dict[Any, Any]

    def __init__(self, *_: Any, **__: Any) -> None: ...

    def __setstate__(self, state: Any) -> None:
        self.state = state

    def __setitem__(self, key: Any, value: Any) -> None:
        self.items[key] = value

    def append(self, value: Any) -> None:
        """Take the place of a list's."""

    def extend(self, values: Any) -> None:
        """Take the place of a list's."""


class Reader(pickle._Unpickler):  # that of C reserves memory for an index of any size
    """Reads the next pickle of an open file; `storages` are those of PyTorch, key -> kind."""

    def __init__(self, handle: Any) -> None:
        super().__init__(handle)
        self.storages: dict[str, str] = {}

    def find_class(self, module: str, name: str) -> type[Inert]:
        return type(name, (Inert,), {"name": f"{module.replace('_core', 'core')}.{name}"})

    def get_extension(self, code: int) -> None:
        raise pickle.UnpicklingError("a registered class")

    def persistent_load(self, pid: Any) -> Any:
        if pid[0] == "module":
            return pid[1]
        self.storages[str(pid[2])] = pid[1].__name__
        return str(pid[2])


def array(content: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the kind, shape and order of the one NumPy array in a pickle, and its bytes.

    Raises DataError for anything else, and for an array that its bytes do not fill.
    """
    try:
        root = Reader(BytesIO(content)).load()
        called = root.name if isinstance(root, Inert) else type(root).__name__
        if called == "numpy.core.multiarray._reconstruct":
            _, shape, kind, turned, values = root.state
        elif called == "numpy.core.numeric._frombuffer":
            values, kind, shape, order = root.arguments
            turned = order == "F"
        else:
            raise TypeError(f"it holds {called}")
        if isinstance(values, Inert):  # bytes as text, of protocols 0 to 2
            (text, _), values = values.arguments, b""
            values = text.encode("latin1")
        code, swapped = kind.arguments[0], kind.state[1]
        if kind.name != "numpy.dtype" or code[0] not in "fiu" or swapped not in "<>|":
            raise TypeError(f"its values are of kind {code}")
        shape = [*map(index, shape)]
        if min(shape, default=0) < 0 or prod(shape) * int(code[1:]) != len(values):
            raise ValueError(f"{len(values)} bytes do not fill shape {shape}")
        dtype = swapped.replace("|", "") + code
    except Exception as error:
        raise DataError(f"it is no array of numbers ({first_line(error)})") from error
    return {"dtype": dtype, "shape": shape, "order": "F" if turned else "C"}, bytes(values)


read_array = Limited(f"{__name__}:array", **LIMITS)
