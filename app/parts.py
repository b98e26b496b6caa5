"""Files of heads and sets that visitors send: kept until they are loaded, or old.

What one visitor sends never removes what another is sending or has just sent. Where there is no
room, the newcomer is refused; what nobody loaded in a while makes room.
"""

import os
import shutil
from collections.abc import AsyncIterator
from hashlib import blake2b
from pathlib import Path
from threading import Lock
from time import time

from app.jobs import BusyError
from app.limits import KEPT_PARTS, PART_S, PARTS, PARTS_BYTES
from app.scratch import Scratch
from omnivat.errors import DataError

UNFINISHED = ".part"
AT_ONCE = 1_000_000  # bytes


class Parts:
    """The files that have arrived, by a name made from their content."""

    def __init__(self, scratch: Scratch) -> None:
        self._scratch = scratch
        self._lock = Lock()
        self._coming = 0  # bytes of unfinished files

    async def keep(self, name: str, content: AsyncIterator[bytes]) -> str:
        """Write one file as it comes; return its name.

        Raises DataError for a file that belongs to no head or set, or is too large, BusyError
        where too much has been sent that is not loaded yet.
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
                    if size > counted:  # a look at the folder for some blocks at a time
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
        """Put the file that `keep` called `sent` at `target`; raises DataError where it is not here."""
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
        """Count `more` bytes as coming; drop what is old where there is no room for them."""
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
