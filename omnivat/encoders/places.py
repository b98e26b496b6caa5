"""Remember where the weights of an encoder lie, so that a head finds its encoder again.

One small JSON file in the cache folder: hash of the weights, or name of a set of images -> path. It
stays on this machine.
"""

import json
from hashlib import blake2b
from pathlib import Path

from omnivat.data.embeddings import Header
from omnivat.errors import WriteError
from omnivat.files import cache_folder, write_json

NEWEST = 200  # places kept


def remember(weights_hash: str, place: Path) -> None:
    """Note where weights were read. A cache that cannot be written costs convenience only."""
    places = _read()
    path = str(place.resolve())
    if places.get(weights_hash) == path:
        return
    places.pop(weights_hash, None)
    places[weights_hash] = path
    try:
        write_json(_file(), dict(list(places.items())[-NEWEST:]))
    except WriteError:
        return


def recall(weights_hash: str) -> Path | None:
    """Return where weights of that hash were read last, if they still lie there."""
    path = _read().get(weights_hash)
    return Path(path) if path and Path(path).exists() else None


def images_key(header: Header) -> str:
    """Return the name under which the folder of a set's images is noted; as a hash of weights is."""
    told = "\x1f".join((*header.key, *header.domains, header.origin.partition(";")[0]))
    return "images " + blake2b(told.encode(), digest_size=8).hexdigest()


def _file() -> Path:
    return cache_folder() / "encoders.json"


def _read() -> dict[str, str]:
    try:
        found = json.loads(_file().read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return {str(k): str(v) for k, v in found.items()} if isinstance(found, dict) else {}
