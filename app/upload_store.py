"""Uploaded files of heads and sets, kept until they are loaded or make room.

Each visitor has a share. Beyond it, the visitor's own oldest files are dropped. If all shares together
are too large, old files are dropped first, then the oldest of the visitor with most.
"""

import os
import shutil
from collections import Counter, OrderedDict
from collections.abc import AsyncIterator
from hashlib import blake2b
from pathlib import Path
from threading import Lock
from time import monotonic

from app.limits import OWN_BYTES, OWN_PARTS, PART_S, PARTS, PARTS_BYTES
from app.messages import BusyError
from app.scratch import Scratch
from omnivat.kit.errors import DataError

AT_ONCE = 1_000_000  # bytes
LEAST = 4096  # bytes that a small file takes on a disk
Entry = tuple[str, str]  # visitor, name


class UploadStore:
    """Uploaded files, named by a hash of their content."""

    def __init__(self, scratch: Scratch) -> None:
        self._scratch = scratch
        self._lock = Lock()
        self._coming: Counter[str] = Counter()  # visitor -> bytes of unfinished files
        self._kept: OrderedDict[Entry, tuple[int, float]] = OrderedDict()  # size, time; oldest first

    async def keep(self, name: str, content: AsyncIterator[bytes], visitor: str = "") -> str:
        """Write one file as it arrives; return its name.

        Raises DataError for another file or one that is too large, BusyError if others have sent too many.
        """
        if name not in PARTS:
            raise DataError(f"'{name:.60}' is no file of a head or set; expected one of {', '.join(PARTS)}.")
        temporary = self._folder() / f"{os.urandom(8).hex()}.part"
        digest, size, counted = blake2b(digest_size=16), 0, 0
        try:
            with temporary.open("wb") as handle:
                async for block in content:
                    size += len(block)
                    if size > counted:  # reserve room once for several blocks
                        self._make_room(visitor, AT_ONCE)
                        counted += AT_ONCE
                    if size > PARTS[name]:
                        raise DataError(
                            f"'{name}' is larger than {PARTS[name] / 1e6:.3g} MB; start the page "
                            "with --head and --embeddings instead."
                        )
                    digest.update(block)
                    handle.write(block)
            with self._lock:
                temporary.replace(self._folder() / digest.hexdigest())
                self._kept.pop((visitor, digest.hexdigest()), None)
                self._kept[visitor, digest.hexdigest()] = max(size, LEAST), monotonic()
        finally:
            temporary.unlink(missing_ok=True)
            with self._lock:
                self._coming[visitor] -= counted
                self._coming += Counter()  # without zeros
        return digest.hexdigest()

    def place(self, name: str, sent: str, target: Path) -> None:
        """Move the file `sent`, named by `keep`, to `target`. Raises DataError if missing."""
        source = self._folder() / sent
        plain = sent.isascii() and sent.isalnum() and len(sent) == 32
        if name not in PARTS or not plain or not source.is_file():
            raise DataError(f"'{name:.60}' has not arrived; choose the files again.")
        target.parent.mkdir(exist_ok=True)
        linked(source, target)

    def _make_room(self, visitor: str, more: int) -> None:
        """Reserve `more` bytes for a visitor; drop files if there is no room."""
        with self._lock:
            self._coming[visitor] += more
            held = self._held()
            own = [one for one in self._kept if one[0] == visitor]
            while own and (held[visitor] > OWN_BYTES or len(own) >= OWN_PARTS):
                held[visitor] -= self._drop(own.pop(0))
            for one in [one for one, (_, when) in self._kept.items() if monotonic() - when > PART_S]:
                if held.total() > PARTS_BYTES:
                    held[one[0]] -= self._drop(one)
            (most, _), *_ = held.most_common(1)
            for one in [one for one in self._kept if one[0] == most]:
                if held.total() > PARTS_BYTES and held[most] > held[visitor]:
                    held[most] -= self._drop(one)
            if held[visitor] > OWN_BYTES or held.total() > PARTS_BYTES:
                self._coming[visitor] -= more
                raise BusyError(
                    "Many files have been sent here and are not loaded yet; try again in "
                    f"{PART_S // 60} minutes, or start the page with --head and --embeddings."
                )

    def _held(self) -> Counter[str]:
        """Return the bytes of each visitor."""
        held = Counter(self._coming)
        for (visitor, _), (size, _) in self._kept.items():
            held[visitor] += size
        return held

    def _drop(self, one: Entry) -> int:
        """Forget a visitor's file, and remove it if no other visitor sent the same; return its size."""
        size, _ = self._kept.pop(one)
        if not any(name == one[1] for _, name in self._kept):
            (self._folder() / one[1]).unlink(missing_ok=True)
        return size

    def _folder(self) -> Path:
        return self._scratch.folder("parts")


def linked(source: str | Path, target: str | Path) -> None:
    """Make `target` the same file as `source`, or a copy where the file system has no links."""
    try:
        Path(target).hardlink_to(source)
    except OSError:
        shutil.copyfile(source, target)
