"""The one place that decides where to compute, and how precisely.

A command takes --device, and `computing_on` makes it hold for everything inside, worker processes
included. Library functions that load or train a head take `current()`; all others work where their
input lies. Sets of embeddings stay in main memory; a batch at a time goes to the device.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from omnivat.errors import SettingsError

if TYPE_CHECKING:
    import torch

VARIABLE = "OMNIVAT_DEVICE"  # names the device where no --device does


def device_from(name: str) -> "torch.device":
    """Return the device called `name`: "cpu", "cuda", "cuda:1", "mps", "meta" or "auto".

    "auto" is a GPU if there is one. "meta" computes shapes and no numbers, for tests.
    Raises SettingsError when the device is not there.
    """
    import torch

    if name == "auto":
        return torch.device("cuda" if torch.cuda.is_available() else "cpu")
    try:
        device = torch.device(name)
    except RuntimeError as error:
        raise SettingsError(f"No device is called '{name}'; use auto, cpu or cuda.") from error
    if device.type == "cuda":
        if not torch.cuda.is_available():
            raise SettingsError(f"Device '{name}' is wanted and no GPU is usable here; use cpu.")
        if device.index is not None and device.index >= torch.cuda.device_count():
            raise SettingsError(
                f"Device '{name}' is wanted and there are {torch.cuda.device_count()} GPUs, counted "
                "from cuda:0."
            )
    if device.type == "mps" and not torch.backends.mps.is_available():
        raise SettingsError(f"Device '{name}' is wanted and no such GPU is usable here; use cpu.")
    return device


def named() -> str:
    """Return the name of the device that holds now: $OMNIVAT_DEVICE, or "cpu"."""
    return os.environ.get(VARIABLE) or "cpu"


def current() -> "torch.device":
    """Return the device that holds now. Raises SettingsError when it is not there."""
    return device_from(named())


@contextmanager
def computing_on(name: str) -> Iterator[None]:
    """Let the device `name` hold inside the block, in processes started there too.

    Raises SettingsError when it is not there.
    """
    device_from(name)
    before = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = name
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(VARIABLE, None)
        else:
            os.environ[VARIABLE] = before


def precise(device: "torch.device") -> "torch.dtype":
    """Return the type in which predictions are alike alone and in a batch: float64 where it exists."""
    import torch

    return torch.float32 if device.type == "mps" else torch.float64
