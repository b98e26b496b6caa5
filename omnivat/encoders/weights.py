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

_OPENAI = ("RN50.pt", "RN101.pt", "ViT-B-32.pt", "ViT-B-16.pt", "ViT-L-14.pt", "ViT-L-14-336px.pt")
WEIGHTS = (*ON_HUB, "open_clip_pytorch_model.bin", *_OPENAI)
NESTED = ("state_dict", "model_state_dict", "model", "teacher", "encoder")


class Weights(dict[str, Tensor]):
    """The floating-point weights of one file by name, as float32; a missing one is a DataError.

    file       their file
    model      name of the model, for errors
    training   the run's name in a training checkpoint; None for plain weights
    """

    def __init__(
        self, state: Mapping[str, Tensor], file: Path, model: str, training: str | None = None
    ) -> None:
        super().__init__(state)
        self.file, self.model, self.training = file, model, training

    def __missing__(self, key: str) -> Tensor:
        raise DataError(f"'{self.file}' lacks the weight '{key}' of {self.model}; fetch it again.")

    def renamed(self, state: Mapping[str, Tensor]) -> "Weights":
        """Return weights of this file under other names."""
        return Weights(state, self.file, self.model, self.training)

    def inside(self, *anchors: str) -> "Weights":
        """Return the part of a model whose names end in one of `anchors`, without what is put
        before them; itself if an anchor is a name of its own.
        """
        for anchor in () if any(anchor in self for anchor in anchors) else anchors:
            for key in self:
                if key.endswith(f".{anchor}"):
                    before = key.removesuffix(anchor)
                    part = {k: v for k, v in self.items() if k.startswith(before)}
                    return self.renamed({k.removeprefix(before): v for k, v in part.items()})
        return self

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
        state = {key: self[key] for key, _ in network.named_parameters()}
        network.load_state_dict(state, strict=False, assign=True)
        network.eval().requires_grad_(False)


def count(state: Mapping[str, Tensor], prefix: str) -> int:
    """Return the number of numbered parts with this prefix."""
    return len({key.removeprefix(prefix).split(".")[0] for key in state if key.startswith(prefix)})


def read_weights(place: Path, name: str) -> Weights:
    """Return the weights in a file, or in the first known file of a folder.

    place   a `.safetensors`, a PyTorch file (read with `weights_only`), a TorchScript archive
            (whose code is not run), or a folder with one; a training checkpoint may nest its
            weights
    name    name of the model, for errors

    Raises DataError if there is no file or it cannot be read.
    """
    file = weights_file(place, name)
    try:
        state, training = _unwrapped(_content(file))
    except Exception as error:  # a damaged file may raise any error in three readers
        raise DataError(
            f"'{file}' cannot be read as weights of {name} ({first_line(error)}); fetch it again,"
            " or save its state dict as a .safetensors file."
        ) from error
    # Copied, because numbers in a mapped file may be unaligned, and the last digits of a product
    # depend on alignment.
    floats = {
        key: value.to(torch.float32, copy=True)
        for key, value in state.items()
        if value.is_floating_point()
    }
    return Weights(floats, file, name, training)


def weights_file(place: Path, name: str) -> Path:
    """Return the weights file of `place`, a file or a folder.

    A folder without a known name may have one `.safetensors`, `.pt`, `.pth` or `.bin` file.
    Raises DataError if there is none.
    """
    if place.is_file():
        return place
    for file in WEIGHTS:
        if (place / file).is_file():
            return place / file
    kinds = (".safetensors", ".pt", ".pth", ".bin")
    others = [file for file in sorted(place.glob("*")) if file.suffix in kinds and file.is_file()]
    if len(others) == 1:
        return others[0]
    why = f"; {len(others)} files could be meant" if others else ""
    raise DataError(
        f"'{place}' has no weights of {name}{why}; name the file, or one of"
        f" {', '.join(WEIGHTS[:4])} is wanted."
    )


def _content(file: Path) -> Any:
    if file.suffix == ".safetensors":
        return load_file(file)
    if is_script(file):
        return read_script(file)
    return torch.load(file, map_location="cpu", weights_only=True)


def _unwrapped(content: Any) -> tuple[Mapping[str, Tensor], str | None]:
    """Return the state dict inside a training checkpoint, and the name of its run."""
    training: str | None = None
    while isinstance(content, Mapping):
        inner = next(
            (content[key] for key in NESTED if isinstance(content.get(key), Mapping)), None
        )
        if inner is None:
            break
        if "epoch" in content or "optimizer" in content:
            training = str(content.get("name", ""))
        content = inner
    if not isinstance(content, Mapping) or not any(isinstance(v, Tensor) for v in content.values()):
        raise ValueError("no table of weights is in it")
    return {str(key): v for key, v in content.items() if isinstance(v, Tensor)}, training


_KINDS = {
    "Double": "float64", "Float": "float32", "Half": "float16", "BFloat16": "bfloat16", "Long": "int64",  # noqa: E501
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
