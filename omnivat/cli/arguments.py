"""Arguments that several commands share, declared once."""

import argparse
from collections.abc import Callable
from pathlib import Path

from omnivat.errors import SettingsError
from omnivat.heads import default_embeddings, default_head
from omnivat.orders import checked_order


def add_head(parser: argparse.ArgumentParser, *, note: str = "") -> None:
    """Declare --head, the folder that `omnivat train` wrote."""
    text = "folder of a trained head; the project's own if left out"
    parser.add_argument("--head", type=Path, default=default_head(), help=text + note)


def add_embeddings(parser: argparse.ArgumentParser) -> None:
    """Declare --embeddings, the file that `omnivat embed` wrote."""
    parser.add_argument(
        "--embeddings",
        type=Path,
        default=default_embeddings(),
        help="embeddings file; the project's simulated domains if left out",
    )


def add_order(parser: argparse.ArgumentParser) -> None:
    """Declare --order, from -4 to 4."""
    parser.add_argument(
        "--order",
        type=order,
        metavar="P",
        help="fractional order p, -4 to 4 quarter turns; the learned one if left out",
    )


def add_seed(parser: argparse.ArgumentParser, *, of: str = "everything that is random") -> None:
    """Declare --seed."""
    parser.add_argument("--seed", type=int, default=0, help=f"seed of {of}; 0 if left out")


def add_json(parser: argparse.ArgumentParser) -> None:
    """Declare --json."""
    parser.add_argument("--json", action="store_true", help="print JSON for programs")


def order(text: str) -> float:
    """Return a fractional order from -4 to 4, as a type of argparse."""
    try:
        return checked_order(float(text))
    except SettingsError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def whole(least: int, most: int | None = None) -> Callable[[str], int]:
    """Return a type of argparse: a whole number from `least` to `most`."""
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
