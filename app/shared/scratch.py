"""The server's temporary folder. It is removed when the server stops, or by the next server.

A lock on a file inside marks a running process; the system releases it when the process ends.
"""

import shutil
from pathlib import Path
from tempfile import gettempdir, mkdtemp
from threading import Lock
from typing import IO, Any
from weakref import finalize

try:
    import fcntl
except ImportError:  # Windows: folders are removed at the end and not swept
    fcntl = None  # type: ignore[assignment]

PREFIX, LOCK = "omnivat-page-", "in-use"


class Scratch:
    """A folder for the lifetime of the process, made on first use."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._home: Path | None = None

    @property
    def home(self) -> Path:
        """The folder itself."""
        with self._lock:
            if self._home is None:
                self._home = Path(mkdtemp(prefix=PREFIX))
                held = _locked(self._home / LOCK)
                finalize(self, _removed, self._home, held)  # at exit, too
            return self._home

    def folder(self, name: str) -> Path:
        """Return a subfolder; create it if needed."""
        folder = self.home / name
        folder.mkdir(exist_ok=True)
        return folder


def _removed(home: Path, held: IO[Any] | None) -> None:
    shutil.rmtree(home, ignore_errors=True)
    if held is not None:
        held.close()


def sweep() -> int:
    """Remove the folders of ended processes; return their number."""
    swept = 0
    for folder in Path(gettempdir()).glob(f"{PREFIX}*"):
        mine = fcntl is not None and not folder.is_symlink() and (folder / LOCK).is_file()
        if mine and (held := _locked(folder / LOCK)) is not None:
            _removed(folder, held)
            swept += 1
    return swept


def _locked(file: Path) -> IO[Any] | None:
    """Return the locked open file; None if another process holds the lock."""
    try:
        handle = file.open("a")
    except OSError:  # another user's folder, or already removed
        return None
    try:
        if fcntl is not None:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return handle
    except OSError:
        handle.close()
        return None
