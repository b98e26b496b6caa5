"""The embedding job: chunks of pairs, the work for one pair, part files, and their merging into
one set.
"""

import json
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import save

from omnivat.data.arranged import ways_of
from omnivat.data.arrays import Column, read_arrays
from omnivat.data.domains import sensor_of
from omnivat.data.embeddings import Array, indices
from omnivat.data.pairs import TEXTS, Pair, PairSet, Skipped
from omnivat.data.relief import Lamps
from omnivat.data.rest import RESTED, rests_of
from omnivat.data.store import ROW_NAMES, Header, vector_type, write_columns
from omnivat.encoders import Encoder
from omnivat.encoders.base import for_modality, made_by
from omnivat.encoders.cache import EmbeddingCache, embed_views
from omnivat.encoders.hub import images_key, remember
from omnivat.encoders.wrapping import takes_of
from omnivat.kit.errors import DataError, WriteError
from omnivat.kit.files import IN_USE, locked, replacing, writing
from omnivat.kit.stages import IMAGES

CHUNK = 128  # pairs in one part file, the most that an interruption loses


@dataclass(frozen=True, slots=True, kw_only=True)
class Chunk:
    """Consecutive pairs. `fingerprint` hashes the files, the encoder and the settings."""

    index: int
    pairs: tuple[Pair, ...]
    flips: tuple[bool, ...]  # the views of an image: False unchanged, True mirrored
    fingerprint: str

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of each pair's vectors."""
        return tuple(name + "_flip" * flip for name in IMAGES for flip in self.flips)


def chunks_of(pairs: Sequence[Pair], encoder: Encoder, flips: tuple[bool, ...]) -> Iterator[Chunk]:
    """Split the pairs into chunks."""
    taken = takes_of(for_modality(encoder, "tac"))
    for index, start in enumerate(range(0, len(pairs), CHUNK)):
        part = tuple(pairs[start : start + CHUNK])
        files = [
            [
                p.tac_crop,
                *filter(None, [p.tac_way]),
                *(_state(file) for file in (p.vis, p.tac, p.tac_rest, p.tac_before) if file),
                *[sensor_of(p.domain)][: "sensor" in taken],
            ]
            for p in part
        ]
        text = json.dumps([made_by(encoder), flips, files])
        fingerprint = blake2b(text.encode(), digest_size=16).hexdigest()
        yield Chunk(index=index, pairs=part, flips=flips, fingerprint=fingerprint)


def _state(path: Path) -> tuple[str, int, int]:
    try:
        found = path.stat()
    except OSError:
        return str(path), -1, -1
    return str(path), found.st_size, found.st_mtime_ns


def embed_one(
    encoder: Encoder, flips: tuple[bool, ...], cache: EmbeddingCache, pair: Pair
) -> list[Array] | Skipped:
    """Return a pair's vectors (D,) in the order of the columns, or the reason of a failure. A
    picture alone is encoded once, and its vectors stand for both.
    """
    of_touch = {
        "crop": pair.tac_crop,
        "rest": pair.tac_rest,
        "before": pair.tac_before,
        "way": pair.tac_way,
    }
    more: dict[str, dict[str, Any]] = {
        "vis": {},
        "tac": of_touch | {"sensor": sensor_of(pair.domain)},
    }
    try:
        made = {
            half: embed_views(
                for_modality(encoder, half, pair.domain),
                getattr(pair, half),
                cache,
                flips=flips,
                **more[half],
            )
            for half in IMAGES
            if pair.alone in ("", half)
        }
    except DataError as error:
        return Skipped(
            what=" + ".join(dict.fromkeys(map(str, (pair.vis, pair.tac)))), why=str(error)
        )
    return [vector for half in IMAGES for vector in made.get(half, made.get(pair.alone, []))]


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A finished chunk: its file, the pairs with vectors, and the reasons for the others."""

    file: Path
    pairs: tuple[Pair, ...]
    skipped: tuple[Skipped, ...]


def part_bytes(chunk: Chunk, results: Sequence[list[Array] | Skipped]) -> bytes:
    """Return the content of a chunk's part file from the results of `embed_one`."""
    skipped = [asdict(result) for result in results if isinstance(result, Skipped)]
    vectors = {
        index: result for index, result in enumerate(results) if not isinstance(result, Skipped)
    }
    arrays: dict[str, NDArray[Any]] = {"kept": np.array(list(vectors), np.int64)}
    for name, column in zip(
        chunk.columns, zip(*vectors.values(), strict=True), strict=bool(vectors)
    ):
        arrays[name] = np.stack(column)
    return bytes(
        save(arrays, metadata={"fingerprint": chunk.fingerprint, "skipped": json.dumps(skipped)})
    )


class Parts:
    """The folder `<out>.parts` of an unfinished set of embeddings."""

    def __init__(self, out: Path) -> None:
        self.folder = out.with_name(out.name + ".parts")

    @contextmanager
    def claimed(self) -> Iterator[None]:
        """Lock the parts for this process; raises WriteError if another process has them."""
        with writing(self.folder):
            self.folder.mkdir(parents=True, exist_ok=True)
            handle = (self.folder / IN_USE).open("a")
        with handle:
            if locked(handle) is False:
                raise WriteError(
                    f"'{self.folder}' belongs to another embed that is still running; wait for it, "
                    "or name another file to write."
                )
            try:
                yield
            finally:
                (self.folder / IN_USE).unlink(missing_ok=True)
                self._remove_if_empty()

    def _file(self, chunk: Chunk) -> Path:
        return self.folder / f"part-{chunk.index:07d}.safetensors"

    def write(self, chunk: Chunk, content: bytes) -> None:
        """Write the part of a chunk, completely or not at all."""
        with replacing(self._file(chunk)) as temporary:
            temporary.write_bytes(content)

    def read(self, chunk: Chunk) -> Part | None:
        """Return the part of a chunk, or None if it is missing, damaged or of other files."""
        file = self._file(chunk)
        try:
            arrays, metadata = read_arrays(file)
            kept, skipped = arrays["kept"], json.loads(metadata["skipped"])
            if metadata["fingerprint"] != chunk.fingerprint:
                return None
        except (SafetensorError, OSError, ValueError, KeyError):
            return None
        pairs = tuple(chunk.pairs[index] for index in kept)
        return Part(file=file, pairs=pairs, skipped=tuple(Skipped(**entry) for entry in skipped))

    def remove(self) -> None:
        """Remove the part files, and the folder if nothing else is in it."""
        for file in self.folder.glob("part-*.safetensors"):
            file.unlink(missing_ok=True)
        for left in self.folder.glob(".part-*.tmp"):  # a killed embed's
            shutil.rmtree(left, ignore_errors=True)
        self._remove_if_empty()

    def _remove_if_empty(self) -> None:
        if self.folder.is_dir() and not any(self.folder.iterdir()):
            self.folder.rmdir()


def merge(
    out: Path,
    parts: Sequence[Part],
    source: PairSet,
    encoder: Encoder,
    columns: Sequence[str],
    *,
    dtype: str,
    manifest: str,
    lamps: Mapping[str, Lamps | str],
) -> Header:
    """Write the parts as one set of embeddings, with one part in memory at a time."""
    pairs = PairSet(pairs=tuple(pair for part in parts for pair in part.pairs))
    rests = rests_of(pairs.pairs)
    header = Header(
        encoder=encoder.name,
        weights_hash=encoder.weights_hash,
        preprocessing=encoder.preprocessing + (RESTED if rests else ""),
        precision=encoder.precision,
        text_hash=getattr(encoder, "text_hash", ""),
        domains=pairs.domains(),
        classes=pairs.materials(),
        simulated=source.simulated,
        origin=source.origin,
        tac_rest=rests,
        tac_way=ways_of(pairs.pairs),
        modalities=pairs.modalities(),
        lamps={name: lamps[name] for name in pairs.domains() if name in lamps},
    )
    kind, shape = vector_type(dtype), (len(pairs.pairs), encoder.width)
    vectors = {
        name: Column(dtype=kind, shape=shape, blocks=_vectors(parts, name)) for name in columns
    }
    files = [path.absolute() for pair in pairs.pairs for path in (pair.vis, pair.tac)]
    root = _shared_folder(files)
    write_columns(
        out,
        header,
        vectors,
        domain=indices(header.domains, [pair.domain for pair in pairs.pairs]),
        label=indices(header.classes, [pair.material for pair in pairs.pairs]),
        rows=_names(pairs.pairs, files, root),
        manifest=manifest,
    )
    if root:
        remember(images_key(header), Path(root))
    return header


def _vectors(parts: Sequence[Part], name: str) -> Iterator[NDArray[Any]]:
    for part in parts:
        if part.pairs:
            yield read_arrays(part.file)[0][name]


def _names(pairs: Sequence[Pair], files: Sequence[Path], root: str) -> dict[str, list[str]]:
    """Return the named columns; `files` has VIS and TAC of every pair in turn, named from
    `root`.
    """
    short = [_text((file.relative_to(root) if root else file).as_posix()) for file in files]
    crops = (
        {"tac_crop": [str(pair.tac_crop) for pair in pairs]}
        if any(pair.tac_crop for pair in pairs)
        else {}
    )
    others = {name: [_text(getattr(pair, name)) for pair in pairs] for name in TEXTS}
    each = [dict(pair.numbers) for pair in pairs]
    measured = dict.fromkeys(name for row in each for name in row if name not in ROW_NAMES)
    numbers = {name: [row.get(name, "") for row in each] for name in measured}
    return {"vis": short[::2], "tac": short[1::2], **others, **crops, **numbers}


def _shared_folder(files: Sequence[Path]) -> str:
    """Return the common folder of all files, at least two levels above a file.

    Short names then keep domain and class, `<domain>/<class>/<name>`.
    """
    try:
        return os.path.commonpath(
            {str(file.parents[min(2, len(file.parents) - 1)]) for file in files}
        )
    except ValueError:  # different drives
        return ""


def _text(name: str) -> str:
    """Return a file's name as valid UTF-8 text."""
    return os.fsencode(name).decode("utf-8", "backslashreplace")
