"""Optional packages, asked for when they are needed and with the reason."""

from importlib import import_module
from types import ModuleType

from omnivat.errors import MissingPackageError


def need(name: str, *, purpose: str, install: str | None = None) -> ModuleType:
    """Import the package `name`, or say what it is for and how to install it.

    A package that is there but broken keeps its own traceback.
    Raises MissingPackageError when `name` itself is not installed.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name.split(".")[0]:
            raise
        raise MissingPackageError(
            f"{name} is needed for {purpose}. Install it with `pip install {install or name}`."
        ) from error
