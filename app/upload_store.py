"""Uploaded files of heads and sets, kept until they are loaded; the oldest make room for new
ones.
"""

import os
import shutil
from collections import OrderedDict
from collections.abc import AsyncIterator
from hashlib import blake2b
from pathlib import Path
from threading import Lock

from app.limits import KEPT_PARTS, PARTS, PARTS_BYTES
from app.scratch import Scratch
from omnivat.kit.errors import DataError


class UploadStore:
    """Uploaded files, named by a hash of their content."""

    def __init__(self, scratch: Scratch) -> None:
        self._scratch = scratch
        self._lock = Lock()
        # name -> bytes; also of unfinished files; oldest first
        self._kept: OrderedDict[str, int] = OrderedDict()

    async def keep(self, name: str, content: AsyncIterator[bytes]) -> str:
        """Write one file as it arrives; return its name. Raises DataError for another file or
        one that is too large.
        """
        if name not in PARTS:
            raise DataError(
                f"'{name:.60}' is no file of a head or set; expected one of {', '.join(PARTS)}."
            )
        temporary = self._folder() / f"{os.urandom(8).hex()}.part"
        digest, size = blake2b(digest_size=16), 0
        try:
            with temporary.open("wb") as handle:
                async for block in content:
                    size += len(block)
                    if size > PARTS[name]:
                        raise DataError(
                            f"'{name}' is larger than {PARTS[name] / 1e6:.3g} MB; start the page "
                            "with --head and --embeddings instead."
                        )
                    self._make_room(temporary.name, size)
                    digest.update(block)
                    handle.write(block)
            with self._lock:
                temporary.replace(self._folder() / digest.hexdigest())
                self._kept.pop(digest.hexdigest(), None)
                self._kept[digest.hexdigest()] = size
        finally:
            temporary.unlink(missing_ok=True)
            with self._lock:
                self._kept.pop(temporary.name, None)
        return digest.hexdigest()

    def place(self, name: str, sent: str, target: Path) -> None:
        """Link the file `sent`, named by `keep`, to `target`. Raises DataError if it is no
        longer there.
        """
        source = self._folder() / sent
        plain = sent.isascii() and sent.isalnum() and len(sent) == 32
        if name not in PARTS or not plain or not source.is_file():
            raise DataError(f"'{name:.60}' has not arrived; choose the files again.")
        target.parent.mkdir(exist_ok=True)
        linked(source, target)

    def _make_room(self, name: str, size: int) -> None:
        """Count `size` bytes for an unfinished file; drop the oldest finished ones beyond the
        limits.
        """
        with self._lock:
            self._kept[name] = size
            finished = [one for one in self._kept if not one.endswith(".part")]
            while finished and (
                len(self._kept) > KEPT_PARTS or sum(self._kept.values()) > PARTS_BYTES
            ):
                del self._kept[finished[0]]
                (self._folder() / finished.pop(0)).unlink(missing_ok=True)

    def _folder(self) -> Path:
        return self._scratch.folder("parts")


def linked(source: str | Path, target: str | Path) -> None:
    """Make `target` the same file as `source`, or a copy where the file system has no links."""
    try:
        Path(target).hardlink_to(source)
    except OSError:
        shutil.copyfile(source, target)
