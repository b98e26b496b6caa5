"""Classes in the labels of other programs: names, or numbers of any type."""

from collections.abc import Sequence
from pathlib import Path

from omnivat.kit.errors import DataError


def labelled_rows(labels: Sequence[str]) -> list[int]:
    """Return the rows with a class: neither a blank nor a negative number."""
    numbers = [_number(text) for text in labels]
    return [k for k, n in enumerate(numbers) if n != "" and not (isinstance(n, int) and n < 0)]


def _number(text: str) -> int | str:
    """Return the whole number in a text, such as "2" or "2.0"; "" for none, else the text."""
    text = text.strip()
    try:
        value = float(text)
    except ValueError:
        return text
    if value != value:  # NaN, as a missing number of pandas
        return ""
    return int(value) if value.is_integer() else text


def class_names(labels: Sequence[str], classes: Sequence[str] | None, place: Path) -> list[str]:
    """Return class names; numbers of any type are looked up in `classes`.

    classes  None: "class 0", "class 1", ...
    Raises DataError for a number without a name.
    """
    numbers = [_number(text) for text in labels]
    if not all(isinstance(number, int) for number in numbers):
        return [*labels]
    if classes is None:
        return [f"class {number}" for number in numbers]
    highest = max(numbers, key=int, default=0)
    if int(highest) >= len(classes):
        raise DataError(
            f"'{place}' has the number {highest} as a material, and the first class is 0; name"
            f" {int(highest) + 1} classes with --classes NAME,NAME,... ({len(classes)} came)."
        )
    return [classes[int(number)] for number in numbers]
