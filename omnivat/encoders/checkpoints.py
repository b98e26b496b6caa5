"""Find a checkpoint: as given, from the environment, in the cache folder, or on the hub."""

import os
from dataclasses import dataclass
from pathlib import Path

from omnivat.encoders import hub
from omnivat.errors import DataError
from omnivat.files import cache_folder


@dataclass(frozen=True, slots=True, kw_only=True)
class Checkpoint:
    """The checkpoint of an encoder, and its sources.

    fetch       a shell command, with {folder} for the destination
    hub         its repository on the Hugging Face hub, or ""
    megabytes   size of the download from the hub
    """

    name: str
    fetch: str
    hub: str = ""
    megabytes: int = 0

    @property
    def variable(self) -> str:
        """The environment variable for its location."""
        return "OMNIVAT_" + self.name.upper().replace("-", "_")

    @property
    def folder(self) -> Path:
        """The default location."""
        return cache_folder() / self.name


def find(checkpoint: Checkpoint, weights: Path | None, *, download: str = "ask") -> Path:
    """Return the folder or file of a checkpoint: as given, by the environment, or by default.

    If none is on disk and no location was given, the hub's cache is searched, and the checkpoint is
    downloaded if `download` allows it (see `hub.fetch`).
    Raises DataError with the command that fetches it.
    """
    given = weights or (Path(path) if (path := os.environ.get(checkpoint.variable)) else None)
    place = given or checkpoint.folder
    if place.exists():
        return place
    why = ""
    if checkpoint.hub and not given:
        found = hub.fetch(checkpoint.hub, megabytes=checkpoint.megabytes, download=download)
        if isinstance(found, Path):
            return found
        why = f" {found}"
    command = checkpoint.fetch.format(folder=checkpoint.folder)
    raise DataError(
        f"There is no checkpoint of {checkpoint.name} at '{place}'.{why} Fetch it with `{command}`, "
        f"or name its place with --weights or ${checkpoint.variable}."
    )
