"""Read weights from any common file, without running its code.

Trainers write a state dict alone or in a checkpoint with much else, under the names that wrappers
gave it, in one file or in shards; OpenAI publishes TorchScript archives. All are read as dotted
names and tensors, from which a model picks its own by the names that it must have.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from math import prod
from pathlib import Path

import torch
from safetensors.torch import load_file
from torch import Tensor, nn

from omnivat.encoders.hub import WEIGHTS as ON_HUB
from omnivat.kit.errors import DataError, first_line
from omnivat.kit.schema import read_object
from omnivat.kit.torch_files import read_tensors

INDEX = ".index.json"
SHARDED = tuple(f"{name}{INDEX}" for name in ("model.safetensors", "pytorch_model.bin"))
WEIGHTS = (*ON_HUB, "open_clip_pytorch_model.bin")
ENDINGS = (".safetensors", ".pt", ".pth", ".bin", ".ckpt")
# what torch.compile, DataParallel, FSDP and checkpointing put before or into names
WRAPPERS = {"_orig_mod", "module", "_fsdp_wrapped_module", "_checkpoint_wrapped_module"}
STORAGES = {
    "FloatStorage": torch.float32,
    "DoubleStorage": torch.float64,
    "HalfStorage": torch.float16,
    "BFloat16Storage": torch.bfloat16,
}
MOST = 4  # cells of all tensors for each byte of their file: some share their values


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


def read_weights(place: Path, name: str, *marks: str) -> Weights:
    """Return the weights in a file, or in the first known file of a folder.

    place   a `.safetensors`, a PyTorch checkpoint or TorchScript archive (whose code is not run),
            the index of shards, or a folder with one
    name    name of the model, for errors
    marks   patterns of a name that the model must have, of which the first that is there counts:
            what precedes it in the file is left out of all names, and names without that, too

    Raises DataError if there is no file, it cannot be read, or it holds several such models.
    """
    file = weights_file(place, name)
    try:
        state = {
            plain_name(key): value for shard in _shards(file) for key, value in _content(shard)
        }
        prefix = _prefix(state, marks)
        # Copied, because numbers in a mapped file may be unaligned, and the last digits of a
        # product depend on alignment.
        floats = {
            key.removeprefix(prefix): value.to(torch.float32, copy=True)
            for key, value in state.items()
            if value.is_floating_point() and key.startswith(prefix)
        }
    except Exception as error:  # a damaged file may raise any error in three readers
        raise DataError(
            f"'{file}' cannot be read as weights of {name} ({first_line(error)}); fetch it again,"
            " or save its state dict as a .safetensors file."
        ) from error
    return Weights(floats, file, name)


def plain_name(key: str) -> str:
    """Return a weight's name without the parts that wrappers of modules add.

    >>> plain_name("module.visual._orig_mod.conv1.weight")
    'visual.conv1.weight'
    """
    return ".".join(part for part in key.split(".") if part not in WRAPPERS)


def _prefix(state: Mapping[str, Tensor], marks: Sequence[str]) -> str:
    """Return what precedes the first mark; of a model and its moving average, that of the model."""
    prefixes: list[str] = []
    for mark in marks:
        pattern = re.compile(rf"((?:.*?\.)??){mark}")
        prefixes = prefixes or sorted(
            {match[1] for key in state if (match := pattern.fullmatch(key))}
        )
    prefixes = [name for name in prefixes if "ema" not in re.split(r"[._]", name)] or prefixes
    if len(prefixes) > 1:
        names = " and ".join(f"'{name}'" for name in prefixes[:3])
        raise DataError(f"it holds several models, whose names begin with {names}")
    return "".join(prefixes)


def weights_file(place: Path, name: str) -> Path:
    """Return the weights file of `place`, a file or a folder.

    A folder without a known name may have one `.safetensors`, `.pt`, `.pth` or `.bin` file.
    Raises DataError if there is none.
    """
    if place.is_file():
        return place
    others = [file for file in sorted(place.glob("*")) if file.suffix in ENDINGS]
    known = [place / file for file in (*WEIGHTS, *SHARDED) if (place / file).is_file()]
    if known or len(others) == 1:
        return (known or others)[0]
    why = f"; {len(others)} files could be meant" if others else ""
    raise DataError(
        f"'{place}' has no weights of {name}{why}; name the file, or one of"
        f" {', '.join(WEIGHTS)} is wanted."
    )


def _shards(file: Path) -> list[Path]:
    """Return the files that an index names, or the file."""
    if not file.name.endswith(INDEX):
        return [file]
    named = {str(name) for name in read_object(file)["weight_map"].values()}
    if outside := [name for name in named if Path(name).name != name]:
        raise DataError(f"its index names a file of another folder, {outside[0]}")
    shards = [file.with_name(name) for name in sorted(named)]
    if absent := [shard.name for shard in shards if not shard.is_file()]:
        raise DataError(f"{absent[0]} of its {len(shards)} shards is not there")
    return shards


def _content(file: Path) -> Iterator[tuple[str, Tensor]]:
    """Yield the tensors of a checkpoint by name, one at a time; each storage is read once."""
    if file.suffix == ".safetensors":
        yield from load_file(file).items()
        return
    found, _ = read_tensors(b"", "it takes too much memory or time", file=str(file.absolute()))
    floats = {
        name: tensor for name, tensor in found["tensors"].items() if tensor[0] in found["storages"]
    }
    if sum(prod(size) for _, _, size, _ in floats.values()) > MOST * file.stat().st_size:
        raise DataError("its tensors have more cells than its bytes can hold")
    storages = {}
    with file.open("rb") as handle:
        for name, (key, offset, size, stride) in floats.items():
            kind, start, length = found["storages"][key]
            if key not in storages and kind in STORAGES:
                handle.seek(start)
                content = bytearray(handle.read(length))
                storages[key] = torch.frombuffer(content, dtype=STORAGES[kind])
            if key in storages:
                yield name, storages[key].as_strided(size, stride, offset)
