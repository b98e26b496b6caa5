"""The embedding job, its chunks of pairs, and the work for one pair."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from omnivat.data.pairs import Pair, Skipped
from omnivat.encoders import Encoder, load_encoder
from omnivat.encoders.base import for_modality
from omnivat.encoders.cache import EmbeddingCache, embed_views
from omnivat.errors import DataError

CHUNK = 128  # pairs in one part file, the most that an interruption loses
Array = NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """Settings of the embedding, as plain values that can be sent to another machine."""

    encoder: str  # "VIS | TAC" for two encoders
    weights: Path | None = None
    tac_weights: Path | None = None
    device: str = "cpu"
    precision: str = "fp32"
    flips: bool = True
    download: str = "ask"

    @property
    def views(self) -> tuple[bool, ...]:
        """The views of an image: False unchanged, True mirrored."""
        return (False, True) if self.flips else (False,)

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of each pair's vectors."""
        return ("vis", "vis_flip", "tac", "tac_flip") if self.flips else ("vis", "tac")

    def load(self) -> Encoder:
        """Load the encoder of this job."""
        return load_encoder(
            self.encoder,
            weights=self.weights,
            tac_weights=self.tac_weights,
            device=self.device,
            precision=self.precision,
            download=self.download,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Chunk:
    """Consecutive pairs. `fingerprint` hashes the files, the encoder and the settings."""

    index: int
    pairs: tuple[Pair, ...]
    fingerprint: str


def chunks_of(pairs: Sequence[Pair], encoder: Encoder, job: Job, size: int = CHUNK) -> Iterator[Chunk]:
    """Split the pairs into chunks of `size`."""
    made_by = [encoder.name, encoder.weights_hash, encoder.preprocessing, encoder.precision, job.columns]
    for index, start in enumerate(range(0, len(pairs), size)):
        part = tuple(pairs[start : start + size])
        rests = [_state(pair.tac_rest) if pair.tac_rest else () for pair in part]
        files = [[*_state(p.vis), *_state(p.tac), p.tac_crop, *rest] for p, rest in zip(part, rests, strict=True)]
        text = json.dumps([made_by, files])
        yield Chunk(index=index, pairs=part, fingerprint=blake2b(text.encode(), digest_size=16).hexdigest())


def _state(path: Path) -> tuple[str, int, int]:
    try:
        found = path.stat()
    except OSError:
        return str(path), -1, -1
    return str(path), found.st_size, found.st_mtime_ns


def embed_one(encoder: Encoder, job: Job, pair: Pair, cache: EmbeddingCache | None = None) -> list[Array] | Skipped:
    """Return a pair's vectors (D,) in the order of `job.columns`, or the reason of a failure."""
    photos, touches = for_modality(encoder, "vis"), for_modality(encoder, "tac")
    try:
        vis = embed_views(photos, pair.vis, cache, flips=job.views)
        tac = embed_views(touches, pair.tac, cache, flips=job.views, crop=pair.tac_crop, rest=pair.tac_rest)
    except DataError as error:
        return Skipped(what=f"{pair.vis} + {pair.tac}", why=str(error))
    return [*vis, *tac]
