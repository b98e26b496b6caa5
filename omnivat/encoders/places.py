"""Remember the location of an encoder's weights, so that a head can find its encoder.

This is one small local JSON file in the cache folder: hash of the weights, or name of an image set
-> path.
"""

import json
from hashlib import blake2b
from pathlib import Path

from omnivat.data.embeddings import Header
from omnivat.errors import WriteError
from omnivat.files import cache_folder, write_json

NEWEST = 200  # entries kept


def remember(weights_hash: str, place: Path) -> None:
    """Store the location of weights. If the cache cannot be written, nothing else fails."""
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
    """Return the last location of weights with that hash, if they are still there."""
    path = _read().get(weights_hash)
    return Path(path) if path and Path(path).exists() else None


def images_key(header: Header) -> str:
    """Return the key for the image folder of a set."""
    text = "\x1f".join((*header.key, *header.domains, header.origin.partition(";")[0]))
    return "images " + blake2b(text.encode(), digest_size=8).hexdigest()


def _file() -> Path:
    return cache_folder() / "encoders.json"


def _read() -> dict[str, str]:
    try:
        found = json.loads(_file().read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return {str(k): str(v) for k, v in found.items()} if isinstance(found, dict) else {}
