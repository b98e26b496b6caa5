"""Labels and object numbers of many pairs as short text, for records."""

import string
from collections.abc import Iterable, Sequence

DIGITS = string.digits + string.ascii_lowercase + string.ascii_uppercase


def digits(labels: Iterable[int]) -> str:
    """Return class indices below 62 as one character each.

    >>> digits([0, 9, 10])
    '09a'
    """
    return "".join(DIGITS[label] for label in labels)


def compact(numbers: Sequence[int]) -> str:
    """Return integers as text: ascending runs as "3-7", others one by one.

    >>> compact([3, 4, 5, 9, 9, 1])
    '3-5 9 9 1'
    """
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][1] + 1:
            parts[-1][1] = number
        else:
            parts.append([number, number])
    return " ".join(str(a) if a == b else f"{a}-{b}" for a, b in parts)


def unpacked(text: str) -> list[int]:
    """Return the numbers that `compact` wrote.

    >>> unpacked("3-5 9 9 1")
    [3, 4, 5, 9, 9, 1]
    """
    found: list[int] = []
    for part in text.split():
        first, _, last = part.partition("-")
        found += range(int(first), int(last or first) + 1)
    return found
