"""Write files completely or not at all; numbers as text."""

import csv
import json
import os
import shutil
import stat
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from glob import escape
from hashlib import file_digest, sha256
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir
from typing import IO, Any

from omnivat.kit.errors import DataError, WriteError

if sys.platform != "win32":  # Windows has no such locks
    import fcntl

FORMULA = ("=", "+", "-", "@", "\t", "\r")  # starts of a cell that a spreadsheet computes
IN_USE = "in-use"  # a locked file in the folder of a running writer


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path; if the block succeeds, the file there replaces `path`.

    A crash at any moment leaves either the old file or the new one.
    Raises WriteError with the file name if the folder, the disk or its permissions prevent it.
    """
    target = path_of(path)
    require_writable(target)
    with writing(target), _beside(target) as folder:
        temporary = folder / "new"
        yield temporary
        with temporary.open("rb") as written:
            os.fsync(written.fileno())
        temporary.chmod(0o644)
        os.replace(temporary, target)


def safe_cell(value: object) -> object:
    """Return a cell of a table that no spreadsheet takes for a formula; numbers stay numbers."""
    if not isinstance(value, str) or not value.lstrip(" ").startswith(FORMULA):
        return value
    try:
        float(value)
    except ValueError:
        return f"'{value}"
    return value


def read_cell(text: str) -> str:
    """Return the text of a cell without the mark of `safe_cell`."""
    return text[1:] if text.startswith("'") and safe_cell(text[1:]) == text else text


def write_csv(path: str | Path, header: Iterable[str], rows: Iterable[Iterable[object]]) -> None:
    """Write a table completely or not at all; every cell is a `safe_cell`. Raises WriteError."""
    with replacing(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as handle:
        writer = csv.writer(handle)
        writer.writerow(map(safe_cell, header))
        writer.writerows(map(safe_cell, row) for row in rows)


@contextmanager
def writing(target: Path) -> Iterator[None]:
    """Turn a failed write into a WriteError with the name of `target` and the reason."""
    try:
        yield
    except WriteError:
        raise
    except OSError as error:
        why = error.strerror or str(error)
        raise WriteError(
            f"'{target}' was not written ({why}); check the folder, its permissions and the free"
            " space."
        ) from error


@contextmanager
def replacing_folder(path: Path) -> Iterator[Path]:
    """Yield an empty folder; it takes the place of `path` if the block ends without an error.

    What stood at `path` goes. Raises WriteError if nothing can be written there.
    """
    with writing(path), _beside(path) as folder:
        made, old = folder / "new", folder / "old"
        made.mkdir()
        yield made
        made.chmod(0o755)
        try:
            if path.exists():
                os.replace(path, old)
            os.replace(made, path)
        finally:
            if old.exists() and not path.exists():
                os.replace(old, path)


@contextmanager
def _beside(target: Path) -> Iterator[Path]:
    """Yield an empty hidden folder next to `target`, in which nothing is left at the end.

    Folders of killed writers of the same target go before; that of a running writer has a lock.
    """
    parent, prefix = target.absolute().parent, f".{target.name}."
    parent.mkdir(parents=True, exist_ok=True)
    _sweep(target)
    while True:
        with (
            TemporaryDirectory(
                dir=parent, prefix=prefix, suffix=".tmp", ignore_cleanup_errors=True
            ) as folder,
            (Path(folder) / IN_USE).open("w") as handle,
        ):
            if locked(handle) is False or not Path(handle.name).exists():
                continue  # another writer swept it before it had its lock
            yield Path(folder)
            return


@contextmanager
def nothing_left(folder: Path) -> Iterator[None]:
    """If the block fails to write, as on a full disk, remove the files that it added to a folder.

    Use it for files that are quick to write again; keep results that took long to compute.
    """
    there, before = folder.exists(), set(folder.rglob("*"))
    try:
        yield
    except OSError:  # WriteError is one
        for added in sorted({*folder.rglob("*")} - before, reverse=True):
            with suppress(OSError):
                added.rmdir() if added.is_dir() else added.unlink()
        if not there:
            with suppress(OSError):
                folder.rmdir()
        raise


def _sweep(target: Path) -> None:
    """Remove the hidden folders that killed writers of `target` left."""
    chance = "?" * 8  # of tempfile's names; with a star "a" would sweep what "a.b" left
    for left in target.absolute().parent.glob(f".{escape(target.name)}.{chance}.tmp"):
        try:
            with (left / IN_USE).open("rb") as handle:
                if not locked(handle):
                    continue
                # it was killed between two renamings
                if (left / "old").exists() and not target.exists():
                    os.replace(left / "old", target)
                shutil.rmtree(left, ignore_errors=True)
        except OSError:  # a file of that name, or a folder that is not ours
            continue


def locked(handle: IO[Any]) -> bool | None:
    """Lock an open file until it is closed; False if another process holds the lock.

    None if the system has no such locks.
    """
    if sys.platform == "win32":
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


def path_of(given: Any) -> Path:
    """Return a path that a caller gave; raises DataError for anything else."""
    if isinstance(given, str | os.PathLike):
        return Path(given)
    raise DataError(
        f"A path was given as {type(given).__name__}; give text, such as 'folder/file', or a"
        " pathlib.Path."
    )


def require_writable(path: str | Path, suffix: str = "") -> None:
    """Check, before long work, that a file can be written.

    suffix  required ending of the name, if any
    Nothing is written to disk. Raises WriteError with the obstacle.
    """
    target = path_of(path)
    if suffix and target.suffix.lower() != suffix:
        raise WriteError(f"'{target}' cannot be the file to write; name one that ends in {suffix}.")
    if "\0" in str(target):
        raise WriteError(f"'{target}' holds a zero byte, which no name may; choose another name.")
    if target.is_dir():
        raise WriteError(f"'{target}' is a folder; name a file to write.")
    if target.exists() and not target.is_file():
        raise WriteError(f"'{target}' is a device and not a file; name a file to write.")
    folder = target.absolute().parent
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    if not folder.is_dir():
        raise WriteError(f"'{target}' cannot be written: '{folder}' is a file; choose a folder.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise WriteError(
            f"'{target}' cannot be written: nothing may be written in '{folder}'; choose another"
            " folder."
        )


@contextmanager
def reading(name: str) -> Iterator[None]:
    """Turn a failed reading into a DataError with the name of the file and the reason."""
    try:
        yield
    except DataError:
        raise
    except (OSError, ValueError) as error:  # a name from a table may hold a zero byte
        why = getattr(error, "strerror", None) or str(error)
        raise DataError(f"'{name}' cannot be read ({why}); check the path.") from error


def require_regular(path: str | Path, name: str = "") -> None:
    """Raise DataError for a missing file, and for a pipe or device, whose reading might never
    end.
    """
    path = path_of(path)
    name = name or str(path)
    with reading(name):
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise DataError(f"'{name}' is a folder, pipe or device; name a file.")


def read_whole(path: str | Path, most: int, name: str = "") -> bytes:
    """Return a file's bytes, at most `most`.

    name  its name in errors; None: the path
    Raises DataError for a missing file, a larger one, or a pipe or device.
    """
    path = path_of(path)
    name = name or str(path)
    at_once = getattr(os, "O_NONBLOCK", 0)  # without waiting for the writer of a pipe
    with (
        reading(name),
        open(path, "rb", opener=lambda p, flags: os.open(p, flags | at_once)) as handle,
    ):
        found = os.fstat(handle.fileno())
        if not stat.S_ISREG(found.st_mode):
            raise DataError(f"'{name}' is a pipe or device; name a file.")
        content = handle.read(min(most, found.st_size) + 1)
    if len(content) > most:
        raise DataError(f"'{name}' is larger than the {most / 1e6:.3g} MB that are read.")
    return content


def hash_of(*files: Path, start: str = "") -> str:
    """Return the SHA-256 of `start` and the content of files, in hexadecimal; 2 GB in 1.3 s."""
    digest = sha256(start.encode())
    for file in files:
        with file.open("rb") as handle:
            file_digest(handle, lambda: digest)
    return digest.hexdigest()


def write_text(path: str | Path, text: str) -> None:
    """Write `text` as UTF-8, completely or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: str | Path, value: Any) -> None:
    """Write `value` as readable JSON, completely or not at all."""
    write_text(path, json.dumps(value, indent=2, ensure_ascii=False) + "\n")


def cache_folder() -> Path:
    """Return the cache folder: $OMNIVAT_CACHE, or the platform's default."""
    if named := os.environ.get("OMNIVAT_CACHE"):
        return Path(named)
    try:
        home = Path.home()
    except RuntimeError:  # a process of an unknown user, without $HOME
        return Path(gettempdir()) / "omnivat-cache"
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / "omnivat"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", home / "AppData" / "Local")) / "omnivat"
    return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache") / "omnivat"
