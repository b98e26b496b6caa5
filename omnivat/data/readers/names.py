"""Checks of file names: images, valid text, printable form."""

import os
import re
from collections.abc import Iterator
from pathlib import Path

from omnivat.errors import printable

is_file = os.path.isfile  # unlike Path.is_file, it never raises for long names
SUFFIXES = "png apng jpg jpeg jpe jfif webp bmp dib tif tiff gif ppm pgm pnm tga jp2 j2k avif"
IMAGE_SUFFIXES = frozenset(f".{suffix}" for suffix in SUFFIXES.split())


def show(path: Path | str) -> str:
    """Return a printable path: invalid bytes and line ends become escapes."""
    return printable(os.fspath(path))


def is_text(name: str) -> bool:
    """True if a file name is valid UTF-8."""
    return not any(0xD800 <= ord(letter) <= 0xDFFF for letter in name)


def is_image_name(name: str) -> bool:
    """True if a file's suffix, in any case, is that of an image."""
    return os.path.splitext(name)[1].lower() in IMAGE_SUFFIXES


def visible(folder: Path) -> Iterator[os.DirEntry[str]]:
    """Yield the entries of a folder, sorted by name, without hidden ones.

    A folder that cannot be listed has none.
    """
    try:
        with os.scandir(folder) as entries:
            found = sorted(entries, key=lambda entry: entry.name)
    except OSError:
        return
    yield from (entry for entry in found if not entry.name.startswith("."))


def folders_in(folder: Path) -> list[Path]:
    """Return the visible folders in `folder`; links to folders come after the folders."""
    found = [entry for entry in visible(folder) if os.path.isdir(entry.path)]
    return [folder / entry.name for entry in sorted(found, key=os.DirEntry.is_symlink)]


def leads_upwards(folder: Path) -> bool:
    """True if a link leads to one of its own parent folders."""
    return folder.is_symlink() and Path(os.path.realpath(folder.parent)).is_relative_to(os.path.realpath(folder))


def number_of(path: Path) -> int | None:
    """Return the number at the end of a file's stem, if any."""
    return int(number[0]) if (number := re.search(r"[0-9]+$", path.stem)) else None


def frames_in(folder: Path, suffixes: frozenset[str] = IMAGE_SUFFIXES) -> dict[int, Path]:
    """Return the frames in a folder by the number at the end of their names, in that order.

    If a frame has two formats, the first by name counts. Names without a number are ignored.
    """
    frames: dict[int, Path] = {}
    for entry in visible(folder):
        path = folder / entry.name
        number = number_of(path)
        if number is not None and path.suffix.lower() in suffixes and is_text(entry.name) and is_file(path):
            frames.setdefault(number, path)
    return dict(sorted(frames.items()))
