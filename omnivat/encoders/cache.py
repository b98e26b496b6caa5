"""Embed each image or pair once: a small cache in memory over files on disk, keyed by content.

The key hashes the bytes of the image, the encoder, its weights, precision and preprocessing, what
an encoder of one's own gives for a test picture, the crop and the mirroring. An entry is one small
file: a checksum, then float32 values. It is written to a temporary file and moved into place, so
two processes cannot corrupt it. An entry with a wrong checksum is computed again.
"""

import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache, partial
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from omnivat.data.images import read_bytes, read_image
from omnivat.data.rest import seen
from omnivat.encoders.base import Encoder, for_modality, made_by
from omnivat.kit.files import cache_folder, replacing

if TYPE_CHECKING:
    import torch

Array = NDArray[np.float32]
Source = str | Path | bytes | Image.Image
READING = "2"  # of image reading; entries of other versions are ignored
DIGEST = 16  # bytes of checksum before an entry's values


class EmbeddingCache:
    """Embeddings by key: at most `in_memory` in memory and `on_disk` in `folder`.

    folder      folder of the entries; None keeps them in memory only
    """

    def __init__(
        self, folder: Path | None = None, *, in_memory: int = 2048, on_disk: int = 20_000
    ) -> None:
        self._folder = folder
        self._in_memory = in_memory
        self._held: OrderedDict[str, Array] = OrderedDict()
        self._lock = threading.Lock()
        if folder is not None:
            _drop_oldest(folder, on_disk)

    def embedding(self, key: str, compute: Callable[[], Array]) -> Array:
        """Return the embedding of `key`; compute it only if it is not cached."""
        with self._lock:
            if key in self._held:
                self._held.move_to_end(key)
                return self._held[key]
        value = self._read(key)
        if value is None:
            value = compute()
            self._write(key, value)
        with self._lock:
            self._held[key] = value
            while len(self._held) > self._in_memory:
                self._held.popitem(last=False)
        return value

    def _place(self, key: str) -> Path | None:
        return None if self._folder is None else self._folder / key[:2] / key[2:]

    def _read(self, key: str) -> Array | None:
        place = self._place(key)
        try:
            content = place.read_bytes() if place else b""
        except OSError:
            return None
        values = content[DIGEST:]
        if not values or content[:DIGEST] != _checksum(values):
            return None
        return np.frombuffer(values, dtype="<f4").astype(np.float32)

    def _write(self, key: str, value: Array) -> None:
        place = self._place(key)
        if place is None:
            return
        values = value.astype("<f4").tobytes()
        try:
            with replacing(place) as temporary:
                temporary.write_bytes(_checksum(values) + values)
        except OSError:  # a full or read-only disk costs time later, but not this result
            self._folder = None


def default_cache() -> EmbeddingCache:
    """Return the cache in $OMNIVAT_CACHE, or in the platform's user cache folder."""
    return EmbeddingCache(cache_folder() / "embeddings")


def embed_image(
    encoder: Encoder,
    source: Source,
    cache: EmbeddingCache | None = None,
    *,
    crop: int = 0,
    rest: Path | None = None,
    way: str = "",
    name: str = "the image",
) -> Array:
    """Return the embedding (D,) of one image: a path, a file's bytes or an open image.

    crop    side of the central square to crop to, in pixels; 0: no crop
    rest    picture of the untouched sensor, to be subtracted
    way     how it is turned, and its channels swapped (`omnivat.data.arranged`)
    name    name of an image that is no path, in errors

    With a cache, the same image is neither decoded nor encoded twice.
    Raises DataError as `read_image` does.
    """
    more: dict[str, Any] = {"crop": crop, "rest": rest, "way": way, "name": name}
    return embed_views(encoder, source, cache, flips=(False,), **more)[0]


def embed_views(
    encoder: Encoder,
    source: Source,
    cache: EmbeddingCache | None = None,
    *,
    crop: int = 0,
    flips: Sequence[bool] = (False, True),
    rest: Path | None = None,
    way: str = "",
    before: Path | None = None,
    sensor: str = "",
    name: str = "the image",
) -> list[Array]:
    """Return an embedding (D,) for each of `flips`, mirrored or not; the image is decoded once.

    rest    picture of the untouched sensor: subtracted, or given to an encoder that takes it
    before  the image of a moment before, for encoders that take it
    sensor  the kind of sensor, likewise
    """
    name = str(source) if isinstance(source, str | Path) else name
    content = source if isinstance(source, Image.Image) else read_bytes(source, name)
    calm = b"" if rest is None else read_bytes(rest)

    from omnivat.encoders.wrapping import WithoutDots, takes_of

    takes = takes_of(encoder)
    earlier = read_bytes(before) if before and "before" in takes else b""
    kind = (getattr(encoder, "sensor", "") or sensor) if "sensor" in takes else ""

    clean: dict[str, Any] = {"clean": encoder.cleaned} if isinstance(encoder, WithoutDots) else {}
    subtracted = b"" if "rest" in takes else calm
    picture: Callable[..., Image.Image] = partial(
        seen, crop=crop, rest=subtracted, way=way, **clean
    )

    @lru_cache(maxsize=1)
    def pixels() -> "torch.Tensor":
        context: dict[str, Any] = {"sensor": kind} if kind else {}
        if earlier:
            context["before"] = picture(earlier, str(before))
        if calm and "rest" in takes:
            context["rest"] = picture(calm, str(rest))
        return encoder.preprocess(picture(content, name), **context)

    def compute(flip: bool) -> Array:
        ready = pixels().flip(-1) if flip else pixels()
        return np.asarray(encoder.embed(ready[None])[0].cpu())

    if cache is None:
        return [compute(flip) for flip in flips]
    keys = _keys(
        encoder,
        content,
        crop,
        flips,
        calm,
        (earlier, kind.encode(), *([way.encode()] if way else [])),
    )
    return [
        cache.embedding(key, partial(compute, flip)) for key, flip in zip(keys, flips, strict=True)
    ]


def embed_pair(
    encoder: Encoder,
    vis: Source | None,
    tac: Source | None,
    cache: EmbeddingCache | None = None,
    *,
    tac_crop: int = 0,
    tac_rest: Path | None = None,
    tac_way: str = "",
) -> tuple[Array | None, Array | None]:
    """Return the embeddings (D,) of a photo and a tactile image; None stays None.

    Raises DataError as `read_image` does.
    """

    def embedded(source: Source | None, modality: str, **views: Any) -> Array | None:
        if source is None:
            return None
        name = f"the {modality.upper()} image"
        return embed_image(for_modality(encoder, modality), source, cache, name=name, **views)

    return embedded(vis, "vis"), embedded(tac, "tac", crop=tac_crop, rest=tac_rest, way=tac_way)


def _keys(
    encoder: Encoder,
    source: bytes | Image.Image,
    crop: int,
    flips: Sequence[bool],
    calm: bytes,
    more: Sequence[bytes],
) -> list[str]:
    """Return the key of each embedding: a hash of encoder, pictures, crop and mirroring."""
    if isinstance(source, Image.Image):
        upright = read_image(source)
        source = f"{upright.size}".encode() + upright.tobytes()
    more = more if any(more) else ()  # the key of an image alone
    parts = (*((calm,) if calm else ()), source, *more)
    contents = [blake2b(content).hexdigest() for content in parts]
    texts = (
        "\x1f".join((READING, *made_by(encoder), *contents, str(crop), str(flip))) for flip in flips
    )
    return [blake2b(text.encode(), digest_size=20).hexdigest() for text in texts]


def _checksum(values: bytes) -> bytes:
    return blake2b(values, digest_size=DIGEST).digest()


def _drop_oldest(folder: Path, keep: int) -> None:
    """Remove all but the newest `keep` entries; another process may do the same."""
    entries = []
    for path in folder.glob("??/*"):
        with suppress(OSError):
            entries.append((path.stat().st_mtime, path))
    for _, path in sorted(entries, reverse=True)[keep:]:
        path.unlink(missing_ok=True)
