"""Tables of names, loaded on use, and optional packages."""

from collections.abc import Callable, Iterable, Mapping
from difflib import get_close_matches
from importlib import import_module
from types import ModuleType
from typing import Any, TypeVar

from omnivat.kit.errors import MissingNameError, MissingPackageError, SettingsError

T = TypeVar("T")


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return " Did you mean 'x'?" for the nearest known name, or nothing."""
    near = get_close_matches(name, list(known), n=1)
    return f" Did you mean '{near[0]}'?" if near else ""


def unknown(name: str, known: Iterable[str], *, kind: str) -> str:
    """Return the sentence for an unknown name: the known ones, and the nearest."""
    known = list(known)
    return f"No {kind} is called '{name}'; there are {', '.join(known)}.{suggestion(name, known)}"


def require_choice(name: str, value: str, choices: Iterable[str]) -> None:
    """Raise SettingsError if an option has none of its values."""
    if value not in (known := list(choices)):
        raise SettingsError(
            f"{name} is '{value}'; choose {', '.join(known)}.{suggestion(value, known)}"
        )


def entry(table: Mapping[str, T], name: str, *, kind: str) -> T:
    """Return `table[name]`. Raises MissingNameError with the known names and the nearest one."""
    if name not in table:
        raise MissingNameError(unknown(name, table, kind=kind))
    return table[name]


def load(table: Mapping[str, str], name: str, *, kind: str) -> Any:
    """Return the object of `table[name]`, a "module:attribute" text, or the module of a "module"
    text; errors as in `entry`.
    """
    module, _, attribute = entry(table, name, kind=kind).partition(":")
    loaded = import_module(module)
    return getattr(loaded, attribute) if attribute else loaded


def late(module: str, table: Mapping[str, str]) -> Callable[[str], Any]:
    """Return the `__getattr__` of a module whose names in `table` load on first use."""

    def find(name: str) -> Any:
        if name not in table:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        return load(table, name, kind="public name")

    return find


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
