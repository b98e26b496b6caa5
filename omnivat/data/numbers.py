"""Columns of numbers beside classes, such as a force: kept as texts, predicted by a ridge probe."""

from collections.abc import Iterable, Sequence
from math import isfinite
from typing import Any

from omnivat.kit.errors import DataError


def are_numbers(texts: Iterable[str]) -> bool:
    """True if texts are finite numbers or blank, and one is a number."""
    there = [text for text in texts if text.strip()]
    try:
        return bool(there) and all(isfinite(float(text)) for text in there)
    except ValueError:
        return False


def numbers_of(
    table: Any, names: Sequence[str], kept: Sequence[int], count: int
) -> dict[str, list[str]]:
    """Return columns of numbers of a file's `Columns` as texts.

    Raises DataError for one that is not there, or holds something else.
    """
    found = {}
    for name in names:
        if (array := table.get(name)) is None or array.shape != (count,):
            raise DataError(
                f"'{table.place}' has no column of numbers '{name}'; it has"
                f" {', '.join(table.names)}."
            )
        texts = ["" if (text := str(value)) == "nan" else text for value in array.tolist()]
        if not are_numbers(texts):
            raise DataError(f"'{table.place}' holds other things than numbers in '{name}'.")
        found[name] = [texts[k] for k in kept]
    return found
