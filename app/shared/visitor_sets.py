"""Heads and sets loaded by visitors, each named by a hash of its content.

A visitor set is the head and the set of pairs that a visitor uses. The server starts with one. A
loaded head or set makes another, which only those with its name can reach. Its folder in the
server's temporary folder holds all that visitors have loaded of it, so that no set needs another;
removing it cancels its unfinished jobs, too.
"""

import os
import shutil
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

from app.shared.limits import DESKS_BYTES, KEPT_DESKS, KEPT_PARTS, PARTS, PARTS_BYTES
from app.shared.places import Places, shipped_places
from app.shared.resources import Resources
from app.shared.state import ForgottenError, Question, Recent, content_name
from omnivat.head.heads import shipped_sets
from omnivat.kit.errors import DataError
from omnivat.kit.files import hash_of
from omnivat.kit.progress import checkpoint

if TYPE_CHECKING:
    from omnivat.head.checkpoint import Head

HEAD = (
    "weights.safetensors",
    "settings.json",
    "metrics.json",
    "familiarity.safetensors",
    "profile.safetensors",
)
SET = "embeddings.safetensors"


class VisitorSets:
    """The first visitor set, and the most recently loaded others."""

    def __init__(self, first: Resources) -> None:
        self.first, self.shared = first, first.shared
        self._lock = Lock()
        self._loaded: Recent[Resources] = Recent(KEPT_DESKS, room=DESKS_BYTES)
        self._shipped: dict[str, Resources] = {}
        # files of heads and sets until they are loaded, by a hash of their content
        self._parts: Recent[Path] = Recent(KEPT_PARTS, room=PARTS_BYTES)

    def named(self, name: str) -> Resources:
        """Return the visitor set of that name, "" for the first one. Raises ForgottenError if it
        is no longer there.
        """
        if not name:
            return self.first
        if name in shipped_sets():  # a set of the project is opened once and stays open
            where, first = shipped_places(name), self.first.where
            if (where.head, where.embeddings) == (first.head, first.embeddings):
                return self.first
            if name not in self._shipped:
                self._shipped.setdefault(name, Resources(where, self.shared, owner=name))
            return self._shipped[name]
        if (loaded := self._loaded.get(name)) is not None:
            return loaded
        raise ForgottenError(
            "The server no longer has the head or set of this address. Load it again in "
            "Try a pair, or go back to the page without `set` in its address."
        )

    def take_part(self, _: Resources, file: Path, question: Question) -> dict[str, str]:
        """Keep one file of a head or set until it is loaded; return its name, `part`. Raises
        DataError for another file or one that is too large.
        """
        name, size = str(question.get("name", "")), file.stat().st_size
        if name not in PARTS:
            raise DataError(
                f"'{name:.60}' is no file of a head or set; expected one of {', '.join(PARTS)}."
            )
        if size > PARTS[name]:
            raise DataError(
                f"'{name}' is larger than {PARTS[name] / 1e6:.3g} MB; start the page with --head"
                " and --embeddings instead."
            )
        part = hash_of(file)
        kept = file.replace(self.shared.scratch.folder("parts") / part)
        for old in self._parts.keep(part, kept, size):
            old.unlink(missing_ok=True)
        return {"part": part}

    def load(self, beside: Resources, question: Question) -> dict[str, str]:
        """Make a visitor set from uploaded files; return its name, `set`.

        beside    the visitor set that provides what is not among the parts
        question  {"parts": file name -> its name from `take_part`, "compare": true to add the head
                  for comparison instead of replacing its own}

        Two equal loads make one visitor set. Raises DataError if the files are no head or set, or
        do not fit together.
        """
        parts, compare = question.get("parts"), question.get("compare") is True
        if not isinstance(parts, dict) or not all(isinstance(part, str) for part in parts.values()):
            raise DataError("parts has to name the files that were sent; choose them again.")
        text = repr((sorted(parts.items()), beside.owner, compare))
        key = content_name(text.encode("utf-8", "backslashreplace"))
        fits = any(name in parts for name in HEAD)  # a set alone may be of another encoder
        if self._loaded.get(key) is None:
            placed = partial(self._placed, parts=parts, base=beside.where, compare=compare)
            self._made(key, placed, beside, fits)
        return {"set": key}

    def adopt(self, head: "Head", *, beside: str) -> str:
        """Make a visitor set from a head trained on the server and the set of `beside`; return
        its name.
        """
        from omnivat.head.checkpoint import save_head

        base = self.named(beside)

        def placed(folder: Path) -> Places:
            saved = save_head(folder / "head", head)
            where = replace(base.where, head=saved, own=None, computed=folder, frames=None)
            return self._alone(where, folder)

        return self._made(os.urandom(12).hex(), placed, base)

    def _made(
        self, key: str, placed: Callable[[Path], Places], beside: Resources, fits: bool = True
    ) -> str:
        """Fill a new folder, check its content and, if it has to, that the heads fit the set;
        add it as a visitor set. One set of pairs is in memory once.
        """
        folder = self.shared.scratch.folder(os.urandom(8).hex())
        try:
            made = Resources(placed(folder), self.shared, owner=key)
            if made.where.embeddings == beside.where.embeddings:
                made.embeddings = beside.embeddings
            checkpoint()
            embeddings = made.embeddings()
            if not len(embeddings):
                raise DataError(f"'{SET}' holds no pairs; embed some and load it again.")
            for name in made.heads if fits else ():
                checkpoint()
                made.head_named(name).require_embeddings(embeddings)
            checkpoint()
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
        with self._lock:  # another request may have made the same visitor set
            dropped = [made] if self._loaded.get(key) else self._loaded.keep(key, made, size)
        for old in dropped:
            if old is not made:
                self.shared.jobs.cancel_owner(old.owner)
            shutil.rmtree(old.where.computed or folder, ignore_errors=True)
        return key

    def _placed(
        self, folder: Path, parts: Mapping[str, str], base: Places, compare: bool
    ) -> Places:
        """Put the parts in their places under `folder`."""
        sent = [name for name in HEAD if name in parts]
        if not sent and SET not in parts:
            raise DataError("Choose the folder of a head, an embeddings file, or both.")
        if sent and (missing := [name for name in HEAD[:2] if name not in parts]):
            raise DataError(f"A head also has {' and '.join(missing)}; choose its whole folder.")
        head = folder / (f"loaded-{len(base.compare) + 1}" if compare else "head")
        for name, part in parts.items():
            kept = self._parts.get(part)
            if name not in PARTS or kept is None:
                raise DataError(f"'{name:.60}' has not arrived; choose the files again.")
            target = (head if name in HEAD else folder) / name
            target.parent.mkdir(exist_ok=True)
            linked(kept, target)
        where = replace(base, computed=folder)
        if sent and compare:
            where = replace(where, compare=(*where.compare, head))
        elif sent:
            where = replace(where, head=head, own=None, frames=None)
        if SET in parts:
            where = replace(where, embeddings=folder / SET, pairs=None, frames=None)
        return self._alone(where, folder)

    def _alone(self, where: Places, folder: Path) -> Places:
        """Return `where` with links under `folder` to what visitors loaded into other folders."""
        home = self.shared.scratch.home

        def here(path: Path) -> Path:
            if home not in path.parents or folder in path.parents:
                return path
            if path.is_dir():
                return Path(shutil.copytree(path, folder / path.name, copy_function=linked))
            for file in path.parent.glob(f"{path.stem}.*"):  # thumbnails are beside a set
                (folder / file.name).unlink(missing_ok=True)
                linked(file, folder / file.name)
            return folder / path.name

        return replace(
            where,
            head=here(where.head),
            embeddings=here(where.embeddings),
            compare=tuple(map(here, where.compare)),
        )


def linked(source: str | Path, target: str | Path) -> None:
    """Make `target` the same file as `source`, or a copy where the file system has no links."""
    try:
        Path(target).hardlink_to(source)
    except OSError:
        shutil.copyfile(source, target)
