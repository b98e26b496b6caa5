"""Find a CLIP checkpoint on disk or on the hub, and read its weights without running its code."""

import logging
import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from zipfile import ZipFile, is_zipfile

import torch
from safetensors.torch import load_file
from torch import Tensor

from omnivat.errors import DataError
from omnivat.files import cache_folder

ON_HUB = ("model.safetensors", "pytorch_model.bin")
WEIGHTS = (*ON_HUB, "open_clip_model.safetensors", "RN50.pt")
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Checkpoint:
    """What an encoder needs and where people get it.

    fetch   a shell command with {folder} for where it shall go
    hub     the repository on the Hugging Face hub that `transformers` reads, or none
    """

    name: str
    fetch: str
    hub: str = ""

    @property
    def variable(self) -> str:
        """The environment variable that can say where it lies."""
        return "OMNIVAT_" + self.name.upper().replace("-", "_")

    @property
    def folder(self) -> Path:
        """Where it is looked for when nothing says otherwise."""
        return cache_folder() / self.name


def find(checkpoint: Checkpoint, weights: Path | None) -> Path:
    """Return the folder or file of a checkpoint: as given, as the environment says, or by default.

    Where none is on disk, the hub is asked.
    Raises DataError with the command that fetches it.
    """
    given = weights or (Path(path) if (path := os.environ.get(checkpoint.variable)) else None)
    place = given or checkpoint.folder
    if place.exists():
        return place
    fetched = None if given or not checkpoint.hub else _from_hub(checkpoint.hub)
    if fetched is None:
        command = checkpoint.fetch.format(folder=checkpoint.folder)
        raise DataError(
            f"There is no checkpoint of {checkpoint.name} at '{place}'; fetch it with `{command}`, "
            f"or name its folder with --weights or ${checkpoint.variable}."
        )
    return fetched


def _from_hub(repository: str) -> Path | None:
    """Return the folder of a snapshot, fetched unless it is there, or None without a network."""
    try:
        from huggingface_hub import snapshot_download
    except ModuleNotFoundError:
        return None
    for weights in ON_HUB:
        try:
            folder = Path(
                snapshot_download(repository, allow_patterns=["*.json", "*.txt", weights])
            )
        except Exception as error:  # the hub's client has its own errors for each kind of no
            _log.info("the hub gave no %s: %s", repository, error)
            return None
        if (folder / weights).is_file():
            return folder
    return None


def read_state(place: Path, name: str) -> dict[str, Tensor]:
    """Return the weights in a file, or in the first known file of a folder, as float32.

    Reads `.safetensors`, plain PyTorch files and TorchScript archives (as OpenAI publishes).
    Raises DataError when there is none or it cannot be read.
    """
    file = _weights_file(place, name)
    try:
        state = load_file(file) if file.suffix == ".safetensors" else _torch_state(file)
    except Exception as error:  # a damaged file may raise anything in three readers
        raise DataError(f"'{file}' cannot be read as weights of {name}; fetch it again.") from error
    # Copied, because a mapped file need not lie where fast products want their numbers to begin,
    # and the last digits of a product depend on it.
    return {
        key: value.to(torch.float32, copy=True)
        for key, value in state.items()
        if value.is_floating_point()
    }


def _weights_file(place: Path, name: str) -> Path:
    if place.is_file():
        return place
    for file in WEIGHTS:
        if (place / file).is_file():
            return place / file
    raise DataError(f"'{place}' has no weights of {name}; one of {', '.join(WEIGHTS)} is wanted.")


def _torch_state(file: Path) -> dict[str, Tensor]:
    if not _is_script(file):
        state: dict[str, Tensor] = torch.load(file, map_location="cpu", weights_only=True)
        return state
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        archive = torch.jit.load(file, map_location="cpu")
    return dict(archive.state_dict())


def _is_script(file: Path) -> bool:
    """Tell a TorchScript archive, weights beside compiled code, which is not run here."""
    if not is_zipfile(file):
        return False
    with ZipFile(file) as archive:
        return any(name.endswith("/constants.pkl") for name in archive.namelist())


def pick(state: dict[str, Tensor], prefixes: tuple[str, ...]) -> dict[str, Tensor]:
    """Return the weights whose names begin with one of `prefixes`."""
    return {key: value for key, value in state.items() if key.startswith(prefixes)}
