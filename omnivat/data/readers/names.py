"""File names as people wrote them: which are images, which can be kept, how to show them."""

import os
import re
from collections.abc import Iterator
from pathlib import Path

from omnivat.errors import printable

IMAGE_SUFFIXES = frozenset(
    f".{suffix}"
    for suffix in (
        *("png", "apng", "jpg", "jpeg", "jpe", "jfif", "webp", "bmp", "dib", "tif", "tiff"),
        *("gif", "ppm", "pgm", "pnm", "tga", "jp2", "j2k", "avif"),
    )
)


def show(path: Path | str) -> str:
    """Return a path that can always be printed: odd bytes and line ends become escapes."""
    return printable(os.fspath(path))


def is_text(name: str) -> bool:
    """Tell whether a file name is valid UTF-8, so that it can be written to a file."""
    return not any(0xD800 <= ord(letter) <= 0xDFFF for letter in name)


def is_image_name(name: str) -> bool:
    """Tell by its suffix, in any case, whether a file is an image."""
    return os.path.splitext(name)[1].lower() in IMAGE_SUFFIXES


def exists(path: Path) -> bool:
    """Tell whether something readable is there; a dangling or looping link is not."""
    return os.path.exists(path)


def is_file(path: Path) -> bool:
    """Tell whether this is a file; unlike Path.is_file, never raises for a name too long."""
    return os.path.isfile(path)


def visible(folder: Path) -> Iterator[os.DirEntry[str]]:
    """Give what lies in a folder, sorted by name, without hidden entries.

    A folder that cannot be listed gives nothing.
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
    """Tell whether a link leads back to a folder that it lies in."""
    return folder.is_symlink() and Path(os.path.realpath(folder)) in (
        Path(os.path.realpath(folder.parent)),
        *Path(os.path.realpath(folder.parent)).parents,
    )


def number_of(path: Path) -> int | None:
    """Return the number that a file's name ends in before its suffix, if any."""
    number = re.search(r"[0-9]+$", path.stem)
    return int(number[0]) if number else None


def frames_in(folder: Path, suffixes: frozenset[str] = IMAGE_SUFFIXES) -> dict[int, Path]:
    """Return the frames in a folder by the number that their name ends in, in its order.

    Of a frame in two formats the first by name counts; a name without a number is no frame.
    """
    frames: dict[int, Path] = {}
    for entry in visible(folder):
        path = folder / entry.name
        number = number_of(path)
        if (
            number is not None
            and path.suffix.lower() in suffixes
            and is_text(entry.name)
            and is_file(path)
        ):
            frames.setdefault(number, path)
    return dict(sorted(frames.items()))
