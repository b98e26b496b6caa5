"""Bring a data set of the model hub, whose client resumes and checks by itself."""

from collections.abc import Sequence
from pathlib import Path

from omnivat.kit.errors import DataError, first_line
from omnivat.kit.files import cache_folder
from omnivat.kit.tables import need

PREFIX = "hf:"


def from_hub(name: str, revision: str, folder: Path, patterns: Sequence[str] = ()) -> Path:
    """Bring the files of the data set `name`, "OWNER/NAME", at a revision into `folder`.

    patterns  of the files that are needed; (): all
    Raises MissingPackageError without huggingface_hub, DataError if the set does not arrive.
    """
    hub = need("huggingface_hub", purpose=f"fetching {name}")
    try:
        hub.snapshot_download(
            name,
            repo_type="dataset",
            revision=revision or None,
            local_dir=folder,
            allow_patterns=list(patterns) or None,
        )
    except Exception as error:  # the hub and its HTTP client have many kinds
        raise DataError(
            f"'{name}' was not fetched from the model hub ({first_line(error)}); check the name and"
            " the network, and run the command again, it goes on."
        ) from error
    return folder


def hub_folder(text: str) -> Path:
    """Return the folder of "hf:OWNER/NAME" or "hf:OWNER/NAME@REVISION" in the user's cache, after
    it is brought. Raises DataError as `from_hub`, and for another text.
    """
    name, _, revision = text.removeprefix(PREFIX).partition("@")
    owner, _, short = name.partition("/")
    if not owner or not short or "/" in short or short.startswith("."):
        raise DataError(f"'{text}' is no data set of the model hub; write it as hf:OWNER/NAME.")
    return from_hub(name, revision, cache_folder() / "hub" / owner / short)
