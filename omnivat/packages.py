"""Optional packages, imported when needed."""

from importlib import import_module
from types import ModuleType

from omnivat.errors import MissingPackageError


def need(name: str, *, purpose: str, install: str | None = None) -> ModuleType:
    """Import the package `name`, or raise an error with its purpose and the install command.

    A broken installed package keeps its own traceback.
    Raises MissingPackageError if `name` itself is not installed.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name.split(".")[0]:
            raise
        raise MissingPackageError(
            f"{name} is needed for {purpose}. Install it with `pip install {install or name}`."
        ) from error
