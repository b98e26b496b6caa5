"""Uploaded files of heads and sets, kept until they are loaded or too old.

An upload never removes a recent upload of another visitor. If there is no room, the new upload is
refused; old files that were not loaded are removed first.
"""

import os
import shutil
from collections.abc import AsyncIterator
from hashlib import blake2b
from pathlib import Path
from threading import Lock
from time import time

from app.limits import KEPT_PARTS, PART_S, PARTS, PARTS_BYTES
from app.messages import BusyError
from app.scratch import Scratch
from omnivat.errors import DataError

UNFINISHED = ".part"
AT_ONCE = 1_000_000  # bytes


class UploadStore:
    """Uploaded files, named by a hash of their content."""

    def __init__(self, scratch: Scratch) -> None:
        self._scratch = scratch
        self._lock = Lock()
        self._coming = 0  # bytes of unfinished files

    async def keep(self, name: str, content: AsyncIterator[bytes]) -> str:
        """Write one file as it arrives; return its name.

        Raises DataError for a file of another kind or one that is too large, BusyError if too many
        uploads are not loaded yet.
        """
        if name not in PARTS:
            raise DataError(
                f"'{name:.60}' is no file of a head or set; expected one of {', '.join(PARTS)}."
            )
        folder = self._folder()
        temporary = folder / f"{os.urandom(8).hex()}{UNFINISHED}"
        digest, size, counted = blake2b(digest_size=16), 0, 0
        try:
            with temporary.open("wb") as handle:
                async for block in content:
                    size += len(block)
                    if size > counted:  # check the folder once for several blocks
                        self._make_room(AT_ONCE)
                        counted += AT_ONCE
                    if size > PARTS[name]:
                        raise DataError(
                            f"'{name}' is larger than {PARTS[name] / 1e6:.3g} MB; start the page "
                            "with --head and --embeddings instead."
                        )
                    digest.update(block)
                    handle.write(block)
            temporary.replace(folder / digest.hexdigest())
        finally:
            temporary.unlink(missing_ok=True)
            with self._lock:
                self._coming -= counted
        return digest.hexdigest()

    def place(self, name: str, sent: str, target: Path) -> None:
        """Move the file `sent`, named by `keep`, to `target`. Raises DataError if missing."""
        source = self._folder() / sent
        plain = sent.isascii() and sent.isalnum() and len(sent) == 32
        if name not in PARTS or not plain or not source.is_file():
            raise DataError(f"'{name:.60}' has not arrived; choose the files again.")
        target.parent.mkdir(exist_ok=True)
        try:
            target.hardlink_to(source)
        except OSError:  # no links on this file system
            shutil.copyfile(source, target)

    def _make_room(self, more: int) -> None:
        """Reserve `more` bytes; remove old files if there is no room."""
        with self._lock:
            kept = [(p.stat(), p) for p in self._folder().iterdir() if p.suffix != UNFINISHED]
            kept.sort(key=lambda entry: entry[0].st_mtime)
            held = self._coming + more + sum(state.st_size for state, _ in kept)
            many = len(kept)
            for state, path in kept:
                if held <= PARTS_BYTES and many < KEPT_PARTS:
                    break
                if time() - state.st_mtime < PART_S:
                    break
                path.unlink(missing_ok=True)
                held, many = held - state.st_size, many - 1
            if held > PARTS_BYTES or many >= KEPT_PARTS:
                raise BusyError(
                    "Many files have been sent here and are not loaded yet; try again in "
                    f"{PART_S // 60} minutes, or start the page with --head and --embeddings."
                )
            self._coming += more

    def _folder(self) -> Path:
        return self._scratch.folder("parts")
