"""Arguments shared by several commands."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from omnivat.config import field_names, parse_assignments
from omnivat.errors import SettingsError
from omnivat.heads import default_embeddings, default_head
from omnivat.orders import checked_order
from omnivat.tables import suggestion


def add_head(parser: argparse.ArgumentParser, *, note: str = "") -> None:
    """Declare --head, a folder from `omnivat train`."""
    text = "folder of a trained head; default: the project's own"
    parser.add_argument("--head", type=Path, default=default_head(), help=text + note)


def add_embeddings(parser: argparse.ArgumentParser) -> None:
    """Declare --embeddings, a file from `omnivat embed`."""
    parser.add_argument(
        "--embeddings",
        type=Path,
        default=default_embeddings(),
        help="embeddings file; default: the project's simulated domains",
    )


def add_order(parser: argparse.ArgumentParser) -> None:
    """Declare --order, from -4 to 4."""
    parser.add_argument(
        "--order",
        type=order,
        metavar="P",
        help="fractional order p, -4 to 4 quarter turns; default: the learned one",
    )


def add_seed(parser: argparse.ArgumentParser, *, of: str = "all random choices") -> None:
    """Declare --seed."""
    parser.add_argument("--seed", type=int, default=0, help=f"seed of {of}; default: 0")


def add_json(parser: argparse.ArgumentParser) -> None:
    """Declare --json."""
    parser.add_argument("--json", action="store_true", help="print JSON")


def order(text: str) -> float:
    """Return a fractional order from -4 to 4, for argparse."""
    try:
        return checked_order(float(text))
    except SettingsError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def whole(least: int, most: int | None = None) -> Callable[[str], int]:
    """Return a type for argparse: a whole number from `least` to `most`."""
    wanted = f"{least} or more" if most is None else f"{least} to {most}"

    def checked(text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"'{text}'; give a whole number, {wanted}") from None
        if number < least or (most is not None and number > most):
            raise argparse.ArgumentTypeError(f"{number}; give a whole number, {wanted}")
        return number

    return checked


def listed(text: str) -> tuple[str, ...]:
    """Return the parts of "a,b,c", stripped."""
    return tuple(part.strip() for part in text.split(",") if part.strip())


def numbers(text: str, *, name: str = "--seeds") -> tuple[int, ...]:
    """Return the whole numbers of "0,1,2"; raises SettingsError for anything else."""
    try:
        found = tuple(int(part) for part in listed(text))
    except ValueError as error:
        raise SettingsError(f"{name} is '{text}'; give whole numbers such as 0,1,2.") from error
    if not found:
        raise SettingsError(f"{name} is empty; give whole numbers such as 0,1,2.")
    return found


def split_settings(texts: list[str], *kinds: type[Any]) -> tuple[dict[str, Any], ...]:
    """Assign each `key=value` text to the settings record with that key.

    Raises SettingsError for an unknown key.
    """
    found: list[dict[str, Any]] = [{} for _ in kinds]
    names = [field_names(kind) for kind in kinds]
    for text in texts:
        key = text.partition("=")[0]
        owner = next((i for i, own in enumerate(names) if key in own), None)
        if owner is None:
            known = [name for own in names for name in own]
            hint = suggestion(key, known) or f" There are {', '.join(known)}."
            raise SettingsError(f"There is no setting '{key}'.{hint}")
        found[owner] |= parse_assignments(kinds[owner], [text])
    return tuple(found)
