"""Find a checkpoint: as given, from the environment, in the cache folder, or on the hub.

The location of weights, and of a set's images, is remembered in one small JSON file in the cache
folder, so that a head finds its encoder."""

import json
import os
import sys
from contextlib import suppress
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from urllib.request import getproxies

from omnivat.data.embeddings import Header
from omnivat.kit.errors import DataError, WriteError
from omnivat.kit.files import cache_folder, write_json
from omnivat.kit.tables import require_choice

POLICIES = ("ask", "yes", "no")
SMALL_FILES = ("*.json", "*.txt")
WEIGHTS = ("model.safetensors", "pytorch_model.bin", "open_clip_model.safetensors")


def fetch(repository: str, *, megabytes: int = 0, download: str = "ask") -> Path | str:
    """Return the folder of a model, cached or downloaded; or the reason of a failure.

    repository  "owner/name"
    megabytes   size shown in the prompt, if known
    download    "yes", "no", or "ask", which prompts on a terminal and otherwise means "no"

    `huggingface_hub` draws its progress bar and keeps its cache ($HF_HOME); $HF_ENDPOINT names a
    mirror, $HTTPS_PROXY a proxy, and $HF_HUB_OFFLINE=1 forbids every download.
    Raises SettingsError for another value of `download`.
    """
    require_choice("download", download, POLICIES)
    from huggingface_hub import constants, try_to_load_from_cache

    for name in WEIGHTS:
        if isinstance(cached := try_to_load_from_cache(repository, name), str):
            return Path(cached).parent
    if download == "no" or constants.HF_HUB_OFFLINE:
        return "Downloads are off (--offline, or $HF_HUB_OFFLINE)."
    size = f" ({megabytes} MB)" if megabytes else ""
    if download == "ask" and not _agreed(f"Download {repository}{size} from the hub? [y/N] "):
        return f"Add --download to fetch {repository}{size} from the hub."
    try:
        return _downloaded(repository)
    except Exception as error:  # the hub's client has its own errors for each kind of failure
        return explained(error, repository)


def explained(error: Exception, repository: str) -> str:
    """Return one sentence with the reason of a failed download and the remedy."""
    from huggingface_hub import constants

    kind, status = type(error).__name__, _status(error)
    if status in (401, 403) or "Gated" in kind:
        return f"The hub refuses {repository} without a login ({kind}); run `hf auth login`."
    if status == 404 or "NotFound" in kind:
        return f"The hub has no complete model '{repository}' ({kind})."
    if status:
        return f"The hub at {constants.ENDPOINT} replied with status {status}; try again later."
    proxy = next((path for scheme in ("https", "http") if (path := getproxies().get(scheme))), "")
    behind = f" through the proxy {proxy}" if proxy else ""
    return (
        f"The hub at {constants.ENDPOINT} cannot be reached{behind} ({kind}); set $HTTPS_PROXY if"
        " this machine is behind a proxy."
    )


def _downloaded(repository: str) -> Path:
    """Download settings, tokenizer and one weights file, safetensors if available."""
    from huggingface_hub import HfApi, snapshot_download

    # One request, because listing files retries for half a minute without a network.
    offered = {file.rfilename for file in HfApi().model_info(repository).siblings or ()}
    weights = next((name for name in WEIGHTS if name in offered), None)
    if weights is None:
        raise FileNotFoundError(f"{repository} offers no weights")
    # Weights last: if they are in the cache, the model is complete.
    snapshot_download(repository, allow_patterns=[*SMALL_FILES])
    return Path(snapshot_download(repository, allow_patterns=[*SMALL_FILES, weights]))


def _agreed(question: str) -> bool:
    """Prompt on a terminal; without one, return False."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        return False
    try:
        return input(question).strip().lower() in ("y", "yes")
    except EOFError:
        return False


def _status(error: BaseException | None) -> int | None:
    """Return the HTTP status of an error or of its cause."""
    while error is not None:
        if (code := getattr(getattr(error, "response", None), "status_code", None)) is not None:
            return int(code)
        error = error.__cause__ or error.__context__
    return None


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
        found = fetch(checkpoint.hub, megabytes=checkpoint.megabytes, download=download)
        if isinstance(found, Path):
            return found
        why = f" {found}"
    command = checkpoint.fetch.format(folder=checkpoint.folder)
    raise DataError(
        f"There is no checkpoint of {checkpoint.name} at '{place}'.{why} Fetch it with `{command}`,"
        f" or name its place with --weights or ${checkpoint.variable}."
    )


MEMORY, NEWEST = "encoders.json", 200  # in the cache folder; entries kept


def remember(weights_hash: str, place: Path) -> None:
    """Store the location of weights. If the cache cannot be written, nothing else fails."""
    places = _read()
    path = str(place.resolve())
    if places.pop(weights_hash, None) == path:
        return
    with suppress(WriteError):
        write_json(cache_folder() / MEMORY, dict([*places.items(), (weights_hash, path)][-NEWEST:]))


def recall(weights_hash: str) -> Path | None:
    """Return the last location of weights with that hash, if they are still there."""
    path = _read().get(weights_hash)
    return Path(path) if path and Path(path).exists() else None


def images_key(header: Header) -> str:
    """Return the key for the image folder of a set."""
    text = "\x1f".join((*header.key, *header.domains, header.origin.partition(";")[0]))
    return "images " + blake2b(text.encode(), digest_size=8).hexdigest()


def _read() -> dict[str, str]:
    try:
        found = json.loads((cache_folder() / MEMORY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return {str(k): str(v) for k, v in found.items()} if isinstance(found, dict) else {}
