"""Bring a data set of the model hub, whose client resumes and checks by itself."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from omnivat.kit.errors import DataError, first_line
from omnivat.kit.files import cache_folder
from omnivat.kit.tables import need

PREFIX = "hf:"
REASONS = (  # kinds of the client's errors, the special ones first
    ("GatedRepoError", "accept its terms on its page, and log in with `hf auth login`"),
    ("RepositoryNotFoundError", "there is none of that name, or it is private: check the name"),
    ("RevisionNotFoundError", "it has no such revision: check what follows the @"),
)
COMMIT = re.compile("[0-9a-f]{12,64}")
NETWORK = "check the name and the network"


def from_hub(name: str, revision: str, folder: Path, patterns: Sequence[str] = ()) -> Path:
    """Bring the files of the data set `name`, "OWNER/NAME", at a revision into `folder`.

    patterns  of the files that are needed; (): all
    Raises MissingPackageError without huggingface_hub, DataError if the set does not arrive.
    """
    with _explained(name) as hub:
        hub.snapshot_download(
            name,
            repo_type="dataset",
            revision=revision or None,
            local_dir=folder,
            allow_patterns=list(patterns) or None,
        )
    return folder


@contextmanager
def _explained(name: str) -> Iterator[Any]:
    hub = need("huggingface_hub", purpose=f"fetching {name}")
    try:
        yield hub
    except Exception as error:  # the hub and its HTTP client have many kinds
        kinds = [kind.__name__ for kind in type(error).__mro__]
        why = next((text for kind, text in REASONS if kind in kinds), "")
        raise DataError(
            f"'{name}' was not fetched from the model hub"
            f"{f'; {why}' if why else f' ({first_line(error)}); {NETWORK}'}, and run the command"
            " again, it goes on."
        ) from error


def hub_folder(text: str) -> Path:
    """Return the folder of "hf:OWNER/NAME" or "hf:OWNER/NAME@REVISION" in the user's cache, after
    it is brought. Raises DataError as `from_hub`, and for another text.

    Each commit has a folder of its own: files that a later one renames would be read twice.
    """
    name, _, revision = text.removeprefix(PREFIX).partition("@")
    owner, _, short = name.partition("/")
    if not owner or not short or "/" in short or short.startswith("."):
        raise DataError(f"'{text}' is no data set of the model hub; write it as hf:OWNER/NAME.")
    with _explained(name) as hub:
        commit = hub.HfApi().repo_info(name, repo_type="dataset", revision=revision or None).sha
    if not isinstance(commit, str) or not COMMIT.fullmatch(commit):  # it names a folder
        raise DataError(
            f"The model hub states no commit of '{name}' but {commit!r:.40}; {NETWORK}, and run the"
            " command again."
        )
    return from_hub(name, commit, cache_folder() / "hub" / owner / commit[:12] / short)
