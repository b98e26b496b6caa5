"""Heads and sets that visitors load through the page, each under a name made from its content.

A desk is what one visitor works with. The server starts with one; a loaded head or set makes
another, known to nobody without its name. Files live in a temporary folder and go with the server.
"""

import os
import shutil
from collections import OrderedDict
from collections.abc import AsyncIterator, Mapping
from dataclasses import replace
from hashlib import blake2b
from pathlib import Path
from tempfile import mkdtemp
from threading import Lock
from weakref import finalize

from app.limits import KEPT_DESKS, KEPT_PARTS, PARTS
from app.resources import Places, Resources
from app.state import ForgottenError
from omnivat.errors import DataError

HEAD = ("weights.safetensors", "settings.json", "metrics.json")
NEEDED_HEAD = HEAD[:2]
SET = "embeddings.safetensors"
SHEET = ("embeddings.thumbnails.webp", "embeddings.thumbnails.json")


class Desks:
    """The first desk, and the most recently loaded others."""

    def __init__(self, first: Resources) -> None:
        self.first = first
        self._lock = Lock()
        self._loaded: OrderedDict[str, Resources] = OrderedDict()
        self._beside: dict[str, str] = {}  # desk -> the desk whose files it uses, too
        self._home: Path | None = None

    def named(self, name: str) -> Resources:
        """Return the desk that a request names; the first one where it names none.

        Raises ForgottenError where the server has it no longer.
        """
        if not name:
            return self.first
        with self._lock:
            if name in self._loaded:
                self._loaded.move_to_end(name)
                return self._loaded[name]
        raise ForgottenError(
            "The server no longer has the head or set of this address. Load it again in "
            "Data & about, or go back to the page without `set` in its address."
        )

    async def keep_part(self, name: str, content: AsyncIterator[bytes]) -> str:
        """Write one file of a head or set as it comes; return what to call it in `load`.

        Raises DataError for a file that belongs to neither, or is too large.
        """
        if name not in PARTS:
            raise DataError(
                f"'{name:.60}' is no file of a head or set; expected one of {', '.join(PARTS)}."
            )
        folder = self._folder("parts")
        temporary = folder / f"{os.urandom(8).hex()}.part"
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
                    digest.update(block)
                    handle.write(block)
            temporary.rename(folder / digest.hexdigest())
        finally:
            temporary.unlink(missing_ok=True)
        self._drop_old_parts(folder)
        return digest.hexdigest()

    def load(self, parts: Mapping[str, str], *, beside: str, compare: bool) -> str:
        """Make a desk of files that were sent; return its name.

        parts    file name -> what `keep_part` called it
        beside   the desk that gives what is not among the parts
        compare  whether the head is to stand beside the desk's own rather than in its place

        Raises DataError in one sentence when the files are not a head or set, or do not fit.
        """
        base = self.named(beside)
        key = _key(parts, beside, compare)
        with self._lock:
            if key in self._loaded:
                return key
        folder = self._folder(key)
        try:
            where = self._placed(folder, parts, base.where, compare=compare)
            desk = Resources(where)
            embeddings = desk.embeddings()
            for name in desk.heads:
                desk.head_named(name).require_embeddings(embeddings)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        with self._lock:
            self._loaded[key], self._beside[key] = desk, beside
            dropped = self._too_many()
        for old in dropped:
            shutil.rmtree(self._folder(old), ignore_errors=True)
        return key

    def _too_many(self) -> list[str]:
        """Forget the desks unused for longest whose files no other desk uses; return them."""
        dropped: list[str] = []
        while len(self._loaded) > KEPT_DESKS:
            used = set(self._beside.values())
            old = next((name for name in self._loaded if name not in used), None)
            if old is None:
                break
            del self._loaded[old], self._beside[old]
            dropped.append(old)
        return dropped

    def _placed(
        self, folder: Path, parts: Mapping[str, str], base: Places, *, compare: bool
    ) -> Places:
        """Put the parts in their places under `folder`."""
        for name, sent in parts.items():
            source = self._folder("parts") / sent
            if name not in PARTS or not sent.isalnum() or not source.is_file():
                raise DataError(f"'{name:.60}' has not arrived; choose the files again.")
            target = folder / ("head" if name in HEAD else ".") / name
            target.parent.mkdir(exist_ok=True)
            shutil.copyfile(source, target)
        where = replace(base, computed=folder, frames=None)
        if any(name in parts for name in HEAD):
            missing = [name for name in NEEDED_HEAD if name not in parts]
            if missing:
                raise DataError(
                    f"A head also has {' and '.join(missing)}; choose its whole folder."
                )
            head = folder / "head"
            where = (
                replace(where, compare=(*base.compare, _renamed(head, len(base.compare))))
                if compare
                else replace(where, head=head)
            )
        if SET in parts:
            sheet = folder / SHEET[0]
            where = replace(
                where,
                embeddings=folder / SET,
                pairs=None,
                sprite=sheet if all(name in parts for name in SHEET) else None,
            )
        elif compare:
            where = replace(where, frames=base.frames)
        if not any(name in parts for name in (*HEAD, SET)):
            raise DataError("Choose the folder of a head, an embeddings file, or both.")
        return where

    def _folder(self, name: str) -> Path:
        with self._lock:
            if self._home is None:
                self._home = Path(mkdtemp(prefix="omnivat-loaded-"))
                finalize(self, shutil.rmtree, self._home, ignore_errors=True)  # at exit, too
        folder = self._home / name
        folder.mkdir(exist_ok=True)
        return folder

    @staticmethod
    def _drop_old_parts(folder: Path) -> None:
        parts = sorted(folder.iterdir(), key=lambda path: path.stat().st_mtime)
        for old in parts[: max(0, len(parts) - KEPT_PARTS)]:
            old.unlink(missing_ok=True)


def _renamed(head: Path, number: int) -> Path:
    """Give a compared head a name of its own."""
    return head.rename(head.with_name(f"loaded-{number + 1}"))


def _key(parts: Mapping[str, str], beside: str, compare: bool) -> str:
    text = repr((sorted(parts.items()), beside, compare))
    return blake2b(text.encode(), digest_size=12).hexdigest()
