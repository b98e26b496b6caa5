"""Read weights from any common file, without running its code.

OpenAI publishes CLIP as TorchScript archives. An archive is a zip: `data.pkl` describes nested
modules, each a table of attributes, and `data/N` holds the values of tensor N. Only these are read
here, and nothing is compiled. The pickle may use only listed names; any other name raises an error.
"""

import pickle
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from zipfile import ZipFile, is_zipfile

import torch
from safetensors.torch import load_file
from torch import Tensor, nn

from omnivat.encoders.hub import WEIGHTS as ON_HUB
from omnivat.kit.errors import DataError, first_line

WEIGHTS = (*ON_HUB, "open_clip_pytorch_model.bin")
ENDINGS = (".safetensors", ".pt", ".pth", ".bin")


class Weights(dict[str, Tensor]):
    """The floating-point weights of one file by name, as float32; a missing one is a DataError.

    file    their file
    model   name of the model, for errors
    """

    def __init__(self, state: Mapping[str, Tensor], file: Path, model: str) -> None:
        super().__init__(state)
        self.file, self.model = file, model

    def __missing__(self, key: str) -> Tensor:
        raise DataError(f"'{self.file}' lacks the weight '{key}' of {self.model}; fetch it again.")

    def renamed(self, state: Mapping[str, Tensor]) -> "Weights":
        """Return weights of this file under other names."""
        return Weights(state, self.file, self.model)

    def fill(self, network: nn.Module) -> None:
        """Give a network its weights, without copies, and freeze it.

        Raises DataError for a missing weight, and for one of another shape.
        """
        for key, own in network.named_parameters():
            if self[key].shape != own.shape:
                raise DataError(
                    f"'{self.file}' has {key} of shape {tuple(self[key].shape)}, expected "
                    f"{tuple(own.shape)}; fetch {self.model} again."
                )
        network.load_state_dict(self, strict=False, assign=True)
        network.eval().requires_grad_(False)


def count(state: Mapping[str, Tensor], prefix: str) -> int:
    """Return the number of numbered parts with this prefix."""
    return len({key.removeprefix(prefix).split(".")[0] for key in state if key.startswith(prefix)})


def read_weights(place: Path, name: str) -> Weights:
    """Return the weights in a file, or in the first known file of a folder.

    place   a `.safetensors`, a PyTorch file (read with `weights_only`), a TorchScript archive
            (whose code is not run), or a folder with one
    name    name of the model, for errors

    Raises DataError if there is no file or it cannot be read.
    """
    file = weights_file(place, name)
    try:
        state = _content(file)
        # Copied, because numbers in a mapped file may be unaligned, and the last digits of a
        # product depend on alignment.
        floats = {
            key: value.to(torch.float32, copy=True)
            for key, value in state.items()
            if isinstance(value, Tensor) and value.is_floating_point()
        }
    except Exception as error:  # a damaged file may raise any error in three readers
        raise DataError(
            f"'{file}' cannot be read as weights of {name} ({first_line(error)}); fetch it again,"
            " or save its state dict as a .safetensors file."
        ) from error
    return Weights(floats, file, name)


def weights_file(place: Path, name: str) -> Path:
    """Return the weights file of `place`, a file or a folder.

    A folder without a known name may have one `.safetensors`, `.pt`, `.pth` or `.bin` file.
    Raises DataError if there is none.
    """
    if place.is_file():
        return place
    others = [file for file in sorted(place.glob("*")) if file.suffix in ENDINGS]
    known = [place / file for file in WEIGHTS if place / file in others]
    if known or len(others) == 1:
        return (known or others)[0]
    why = f"; {len(others)} files could be meant" if others else ""
    raise DataError(
        f"'{place}' has no weights of {name}{why}; name the file, or one of"
        f" {', '.join(WEIGHTS)} is wanted."
    )


def _content(file: Path) -> Mapping[str, Any]:
    if file.suffix == ".safetensors":
        return load_file(file)
    if is_script(file):
        return read_script(file)
    content: Mapping[str, Any] = torch.load(file, map_location="cpu", weights_only=True)
    return content


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
        with archive.open(inside) as handle:
            module = _Reader(handle, archive, inside.removesuffix(".pkl")).load()
    return dict(_tensors(module, ""))


class _Module:
    """A scripted module, read as the table of its attributes."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.attributes = state


def _tensor(numbers: Tensor, offset: int, size: Any, stride: Any, *_: Any) -> Tensor:
    return numbers.as_strided(size, stride, offset)


_KNOWN = {
    ("collections", "OrderedDict"): OrderedDict,
    ("torch._utils", "_rebuild_tensor_v2"): _tensor,
    ("torch.jit._pickle", "build_intlist"): list,
    ("torch", "FloatStorage"): torch.float32,
    ("torch", "HalfStorage"): torch.float16,
    ("torch", "LongStorage"): torch.int64,
}


class _Reader(pickle.Unpickler):
    """Build modules, tensors and plain values; raise an error for any other class or function."""

    def __init__(self, handle: Any, archive: ZipFile, folder: str) -> None:
        super().__init__(handle)
        self._archive, self._folder = archive, folder

    def find_class(self, module: str, name: str) -> Any:
        if module.startswith("__torch__"):
            return _Module
        if (module, name) in _KNOWN:
            return _KNOWN[module, name]
        raise pickle.UnpicklingError(f"the archive calls {module}.{name}")

    def persistent_load(self, pid: Any) -> Tensor:
        _, dtype, key, *_ = pid
        content = bytearray(self._archive.read(f"{self._folder}/{key}"))
        return torch.frombuffer(content, dtype=dtype)


def _tensors(module: Any, prefix: str) -> Iterator[tuple[str, Tensor]]:
    for name, value in module.attributes.items():
        if isinstance(value, Tensor):
            yield prefix + name, value
        elif isinstance(value, _Module):
            yield from _tensors(value, f"{prefix}{name}.")
