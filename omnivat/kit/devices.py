"""Choice of the device and its precision.

Commands accept --device; `computing_on` applies it to all work inside, including worker processes.
Functions that load or train a head use `current()`; all others use the device of their input. Sets
of embeddings stay in main memory, and single batches move to the device.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from omnivat.kit.errors import SettingsError, first_line

if TYPE_CHECKING:
    import torch

VARIABLE = "OMNIVAT_DEVICE"  # the device without --device


def device_from(name: str) -> "torch.device":
    """Return the device called `name`: "cpu", "cuda", "cuda:1", "mps", "meta" or "auto".

    "auto" is a GPU if there is one. "meta" computes only shapes, for tests.
    Raises SettingsError if the device does not exist.
    """
    import torch

    if name == "auto":
        return torch.device("cuda" if torch.cuda.is_available() else "cpu")
    try:
        return torch.empty(0, device=name).device
    except (RuntimeError, AssertionError) as error:
        raise SettingsError(
            f"Device '{name}' is not usable here ({first_line(error)}); use auto, cpu or cuda."
        ) from error


def named() -> str:
    """Return the name of the current device: $OMNIVAT_DEVICE, or "cpu"."""
    return os.environ.get(VARIABLE) or "cpu"


def current() -> "torch.device":
    """Return the current device. Raises SettingsError if it does not exist."""
    return device_from(named())


@contextmanager
def computing_on(name: str) -> Iterator[None]:
    """Use the device `name` inside the block, also in processes started there.

    Raises SettingsError if it does not exist.
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
    """Return the dtype for batch-independent predictions: float64 if the device has it."""
    import torch

    return torch.float32 if device.type == "mps" else torch.float64
