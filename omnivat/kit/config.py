"""Frozen settings, made from JSON or `key=value` texts; unknown names are errors."""

import json
from argparse import ArgumentTypeError
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields
from functools import cache
from math import inf
from numbers import Integral
from typing import Any, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

from omnivat.kit.errors import SettingsError
from omnivat.kit.tables import suggestion

S = TypeVar("S")


class Within(NamedTuple):
    """The range of a number, ends included, for a field: `Annotated[int, Within(1, 9)]`."""

    low: float
    high: float

    def allows(self, value: Any) -> bool:
        """True if the value is in the range; NaN never is."""
        return bool(self.low <= value <= self.high)

    def __str__(self) -> str:
        return f"{self.low:g} to {self.high:g}"


class OneOf(NamedTuple):
    """The allowed texts of a field: `Annotated[str, OneOf(NAMES)]`."""

    names: tuple[str, ...]

    def allows(self, value: Any) -> bool:
        """True if the value is one of the names."""
        return value in self.names

    def __str__(self) -> str:
        return f"one of {', '.join(self.names)}"


def is_count(value: Any, least: int = 0) -> bool:
    """True for a whole number from `least` up; a truth value is none."""
    return not isinstance(value, bool) and isinstance(value, Integral) and int(value) >= least


def declared(kind: type[Any]) -> dict[str, Within | OneOf]:
    """Return the declared range or names of each field of a settings record."""
    hints = get_type_hints(kind, include_extras=True)
    return {
        name: limit
        for name, hint in hints.items()
        for limit in getattr(hint, "__metadata__", ())
        if isinstance(limit, Within | OneOf)
    }


def require_declared(settings: object) -> None:
    """Raise SettingsError for a value that its field does not allow."""
    for name, limit in declared(type(settings)).items():
        value = getattr(settings, name)
        if not limit.allows(value):
            shown = f"'{value}'" if isinstance(value, str) else f"{value}"
            near = suggestion(str(value), limit.names) if isinstance(limit, OneOf) else ""
            raise SettingsError(f"{name} is {shown}; choose {limit}.{near}")


def settings_from(kind: type[S], values: Mapping[str, Any]) -> S:
    """Return the settings record `kind` with `values`; other fields keep their defaults.

    Raises SettingsError for an unknown name (and suggests the nearest) or a wrong type.
    """
    return kind(**{name: _fit(kind, name, value) for name, value in values.items()})


def parse_assignments(kind: type[Any], texts: Sequence[str]) -> dict[str, Any]:
    """Return {name: value} for texts such as "levels=2", with the types of the fields of `kind`.

    Raises SettingsError for a text without "=", an unknown name or a value that does not parse.
    """
    values = {}
    for text in texts:
        name, equals, raw = text.partition("=")
        if not equals:
            raise SettingsError(f"--set got '{text}'; write it as key=value.")
        try:
            value = json.loads(raw)
        except ValueError:
            value = {"True": True, "False": False}.get(raw, raw)
        values[name] = _fit(kind, name, value)
    return values


def field_names(kind: type[Any]) -> list[str]:
    """Return the names of the settings in their order."""
    return [field.name for field in fields(kind)]


def _fit(kind: Any, name: str, value: Any) -> Any:
    hints = _hints(kind)
    if name not in hints:
        hint = suggestion(name, hints) or f" There are {', '.join(hints)}."
        raise SettingsError(f"{kind.__name__} has no setting '{name}'.{hint}")
    hint = hints[name]
    fitted = _fit_one(hint, value)
    if fitted is _NO:
        raise SettingsError(f"Setting '{name}' is {value!r}; it must be {hint.__name__}.")
    return fitted


_NO = object()


_hints = cache(get_type_hints)


def _fit_one(hint: Any, value: Any) -> Any:
    if get_origin(hint) is tuple and isinstance(value, list | tuple):
        fitted = tuple(_fit_one(get_args(hint)[0], item) for item in value)
        return _NO if _NO in fitted else fitted
    if hint is float and (isinstance(value, float) or type(value) is int):
        return float(value)
    return value if type(value) is hint else _NO


def whole(least: int, most: float = inf) -> Callable[[str], int]:
    """Return a type for argparse: a whole number from `least` to `most`."""
    wanted = f"{least} or more" if most == inf else f"{least} to {most}"

    def checked(text: str) -> int:
        with suppress(ValueError):
            if least <= (number := int(text)) <= most:
                return number
        raise ArgumentTypeError(f"'{text}'; give a whole number, {wanted}")

    return checked
