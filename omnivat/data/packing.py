"""Labels, object numbers and probabilities of many pairs as short text, for records and the
page.
"""

import string
from base64 import b64encode
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from omnivat.kit.errors import DataError

DIGITS = string.digits + string.ascii_lowercase + string.ascii_uppercase


def digits(labels: Iterable[int]) -> str:
    """Return class indices below 62 as one character each."""
    return "".join(DIGITS[label] for label in labels)


def compact(numbers: Sequence[int]) -> str:
    """Return integers as text: ascending runs as "3-7", others one by one."""
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][1] + 1:
            parts[-1][1] = number
        else:
            parts.append([number, number])
    return " ".join(str(a) if a == b else f"{a}-{b}" for a, b in parts)


def unpacked(text: str) -> list[int]:
    """Return the numbers that `compact` wrote."""
    found: list[int] = []
    for part in text.split():
        first, _, last = part.partition("-")
        found += range(int(first), int(last or first) + 1)
    return found


def odds(logs: ArrayLike) -> str:
    """Return logits (N, K) in half precision: each less that of the last class, as base64."""
    values = np.asarray(logs, dtype=np.float64)
    return b64encode(
        (values[:, :-1] - values[:, -1:]).clip(-6e4, 6e4).astype("<f2").tobytes()
    ).decode()


def packed(values: NDArray[Any], kind: str, steps: int = 1) -> dict[str, Any]:
    """Return numbers (N,) as integers in units of 1 / steps, little-endian, in base64.

    kind  "u1", "u2" or "i2", numpy's names

    Raises DataError if a number is not finite.
    """
    if not np.isfinite(values).all():
        raise DataError(
            "The head gives values that are not finite numbers; its weights are damaged. Train it"
            " again."
        )
    whole = np.rint(values.astype(np.float64) * steps).astype(f"<{kind}")
    return {"kind": kind, "steps": steps, "data": b64encode(whole.tobytes()).decode()}
