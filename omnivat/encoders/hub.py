"""Download a model from the Hugging Face hub, with consent, or return the reason for failure."""

import os
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

from omnivat.errors import SettingsError

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
    if download not in POLICIES:
        raise SettingsError(f"download is '{download}'; choose {', '.join(POLICIES)}.")
    if find_spec("huggingface_hub") is None:
        return "Downloads need `pip install huggingface_hub`."
    if (cached := _cached(repository)) is not None:
        return cached
    if download == "no" or _offline():
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
    kind, status = type(error).__name__, _status(error)
    if status in (401, 403) or "Gated" in kind:
        return f"The hub refuses {repository} without a login ({kind}); run `hf auth login`."
    if status == 404 or "NotFound" in kind:
        return f"The hub has no complete model '{repository}' ({kind})."
    if status == 407 or "Proxy" in kind:
        return f"The proxy refused the connection to the hub ({kind}); check $HTTPS_PROXY."
    if status:
        return f"The hub at {_endpoint()} replied with status {status}; try again later."
    names = ("HTTPS_PROXY", "https_proxy", "HTTP_PROXY", "http_proxy")
    proxy = next((os.environ[name] for name in names if os.environ.get(name)), "")
    behind = f" through the proxy {proxy}" if proxy else ""
    return (
        f"The hub at {_endpoint()} cannot be reached{behind} ({kind}); set $HTTPS_PROXY if this "
        "machine is behind a proxy."
    )


def _cached(repository: str) -> Path | None:
    """Return the folder of a model with weights in the hub's cache, or None."""
    from huggingface_hub import try_to_load_from_cache

    for name in WEIGHTS:
        found = try_to_load_from_cache(repository, name)
        if isinstance(found, str):
            return Path(found).parent
    return None


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


def _agreed(question: str, ask: Callable[[str], str] = input) -> bool:
    """Prompt on a terminal; without one, return False."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        return False
    try:
        return ask(question).strip().lower() in ("y", "yes")
    except EOFError:
        return False


def _offline() -> bool:
    from huggingface_hub import constants

    return bool(constants.HF_HUB_OFFLINE)


def _endpoint() -> str:
    from huggingface_hub import constants

    return str(constants.ENDPOINT)


def _status(error: BaseException | None) -> int | None:
    """Return the HTTP status of an error or of its cause."""
    while error is not None:
        response = getattr(error, "response", None)
        if (code := getattr(response, "status_code", None)) is not None:
            return int(code)
        error = error.__cause__ or error.__context__
    return None
