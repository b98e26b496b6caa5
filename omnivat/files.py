"""Write files whole or not at all."""

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any

from omnivat.errors import WriteError


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside `path`; when the block ends well it takes the place of `path`.

    A crash at any moment leaves either the old file or the new one.
    Raises WriteError, naming the file, where the folder, the disk or its rights do not allow it.
    """
    target = Path(path)
    require_writable(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with _temporary(target) as temporary:
            yield temporary
            with temporary.open("rb") as written:
                os.fsync(written.fileno())
            os.chmod(temporary, 0o644)
            os.replace(temporary, target)
    except WriteError:
        raise
    except OSError as error:
        why = error.strerror or str(error)
        raise WriteError(
            f"'{target}' was not written ({why}); look at the folder, its rights and the free space."
        ) from error


@contextmanager
def _temporary(target: Path) -> Iterator[Path]:
    """Give a new file beside `target` that is gone when the block ends."""
    with NamedTemporaryFile(
        dir=target.parent, prefix=f".{target.name}.", suffix=".tmp", delete=False
    ) as handle:
        temporary = Path(handle.name)
    try:
        yield temporary
    finally:
        temporary.unlink(missing_ok=True)


def require_writable(path: str | Path, suffix: str = "") -> None:
    """Refuse a place where no file can be written, before long work is done for it.

    suffix  how the name must end, where that matters
    Nothing is made on disk. Raises WriteError with what is in the way.
    """
    target = Path(path)
    if suffix and target.suffix.lower() != suffix:
        raise WriteError(f"'{target}' cannot be the file to write; name one that ends in {suffix}.")
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
            f"'{target}' cannot be written: nothing may be written in '{folder}'; "
            "choose another folder."
        )


def write_text(path: str | Path, text: str) -> None:
    """Write `text` as UTF-8, whole or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: str | Path, value: Any) -> None:
    """Write `value` as readable JSON, whole or not at all."""
    write_text(path, json.dumps(value, indent=2, ensure_ascii=False) + "\n")


def cache_folder() -> Path:
    """Return the folder for what can be fetched or computed again: $OMNIVAT_CACHE, or the usual."""
    if named := os.environ.get("OMNIVAT_CACHE"):
        return Path(named)
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "omnivat"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "omnivat"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "omnivat"
