"""Archives, which their authors may have cut into parts, read and unpacked without a joined copy on
the disk; and folders as their files.
"""

import shutil
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import SEEK_CUR, SEEK_END, BufferedReader, RawIOBase
from itertools import accumulate
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from omnivat.kit.errors import DataError, WriteError, first_line
from omnivat.kit.files import read_whole, writing
from omnivat.kit.progress import OnStep, Step, ignore

MOST = 300_000_000  # bytes of a file


class Joined(RawIOBase):
    """The bytes of several files, one after the other, for reading."""

    def __init__(self, files: Sequence[Path]) -> None:
        self._files = list(files)
        self._starts = [0, *accumulate(file.stat().st_size for file in files)]
        self._at = 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def tell(self) -> int:
        return self._at

    def seek(self, offset: int, whence: int = 0) -> int:
        """Move to a byte; `whence` as in `io.IOBase.seek`."""
        self._at = offset + {SEEK_CUR: self._at, SEEK_END: self._starts[-1]}.get(whence, 0)
        return self._at

    def readinto(self, buffer: Any) -> int:
        """Fill `buffer` from the file at the present byte; return how many bytes came."""
        if self._at >= self._starts[-1]:
            return 0
        part = bisect_right(self._starts, self._at) - 1
        with self._files[part].open("rb") as file:
            file.seek(self._at - self._starts[part])
            count = file.readinto(buffer)
        self._at += count
        return count


@dataclass(frozen=True, slots=True)
class Folder:
    """The files below a folder by their paths."""

    root: Path

    @property
    def names(self) -> list[str]:
        """The paths, with slashes."""
        return [f.relative_to(self.root).as_posix() for f in self.root.rglob("*") if f.is_file()]

    def contents(self, paths: Iterable[str]) -> Iterator[tuple[str, bytes]]:
        """Yield paths and contents; raises DataError for a file that cannot be read."""
        for path in paths:
            yield path, read_whole(self.root / path, MOST)


@dataclass(frozen=True, slots=True)
class Zipped:
    """The files in a zip archive by their paths."""

    archive: ZipFile
    place: Path

    @property
    def names(self) -> list[str]:
        """The paths, with slashes."""
        return self.archive.namelist()

    def contents(self, paths: Iterable[str]) -> Iterator[tuple[str, bytes]]:
        """Yield paths and contents; raises DataError for a file of more than MOST bytes."""
        for path in paths:
            if self.archive.getinfo(path).file_size > MOST:
                raise DataError(f"'{path}' of the archive is larger than {MOST / 1e6:.0f} MB.")
            with _explained(self.place):
                content = self.archive.read(path)
            yield path, content


@contextmanager
def _explained(place: Path) -> Iterator[None]:
    try:
        yield
    except Exception as error:  # a damaged archive raises errors of every kind
        raise DataError(
            f"'{place}' is no whole archive ({first_line(error)}); remove it and run the command"
            " again."
        ) from error


@contextmanager
def zipped(parts: Sequence[Path]) -> Iterator[Zipped]:
    """Open a zip archive in one or more parts; raises DataError if it is damaged."""
    with BufferedReader(Joined(parts), 1 << 20) as stream:
        with _explained(parts[0]):
            archive = ZipFile(stream)
        with archive:
            yield Zipped(archive, parts[0])


def unpacked(parts: Sequence[Path], folder: Path, on_step: OnStep = ignore) -> list[Path]:
    """Unpack a zip archive in parts into `folder`; return its files.

    No file lands outside of `folder`. Raises DataError for a damaged archive, WriteError if the
    disk has no room.
    """
    found = []
    folder.mkdir(parents=True, exist_ok=True)
    try:
        with BufferedReader(Joined(parts), 1 << 20) as stream, ZipFile(stream) as archive:
            members = archive.infolist()
            size, free = sum(member.file_size for member in members), shutil.disk_usage(folder).free
            if size > free:
                raise WriteError(
                    f"The archive unpacks to {size / 1e6:,.0f} MB, and '{folder}' has"
                    f" {free / 1e6:,.0f} MB free."
                )
            for done, member in enumerate(members):
                on_step(Step(done=done, total=len(members), text="files of the archive"))
                with writing(folder):
                    found.append(Path(archive.extract(member, folder)))
    except WriteError:
        raise
    except Exception as error:  # a damaged archive finds an error of every kind
        raise DataError(
            f"The parts in '{folder.parent}' are no whole archive ({first_line(error)}); remove"
            " that folder and run the command again."
        ) from error
    return [file for file in found if file.is_file()]
