"""Choose a device in an entry point; library functions work where their input lies."""

from typing import TYPE_CHECKING

from omnivat.errors import SettingsError

if TYPE_CHECKING:
    import torch


def device_from(name: str) -> "torch.device":
    """Return the device called `name`: "cpu", "cuda", "cuda:1" or "auto" (a GPU if there is one).

    Raises SettingsError when the device is not there.
    """
    import torch

    if name == "auto":
        return torch.device("cuda" if torch.cuda.is_available() else "cpu")
    try:
        device = torch.device(name)
    except RuntimeError as error:
        raise SettingsError(f"No device is called '{name}'; use auto, cpu or cuda.") from error
    if device.type == "cuda" and not torch.cuda.is_available():
        raise SettingsError(f"Device '{name}' was asked for and no GPU is usable here; use cpu.")
    return device
