"""Look up a name in a table, and import its target on first use."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from importlib import import_module
from typing import Any

from omnivat.errors import MissingNameError


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return " Did you mean 'x'?" for the nearest known name, or nothing."""
    near = get_close_matches(name, list(known), n=1)
    return f" Did you mean '{near[0]}'?" if near else ""


def load(table: Mapping[str, str], name: str, *, kind: str) -> Any:
    """Return the object of `table[name]`, a "module:attribute" text.

    Raises MissingNameError with the known names and the nearest one.
    """
    if name not in table:
        known = ", ".join(table)
        raise MissingNameError(
            f"No {kind} is called '{name}'; there are {known}.{suggestion(name, table)}"
        )
    module, attribute = table[name].split(":")
    return getattr(import_module(module), attribute)
