"""Records of runs as JSON lines. The key of a line hashes everything that affects its figures."""

import json
import os
import platform
from collections.abc import Mapping
from hashlib import blake2b
from importlib.metadata import version
from pathlib import Path
from typing import Any

import torch

from omnivat import __version__
from omnivat.data.arrays import walked
from omnivat.data.store import Embeddings
from omnivat.encoders.lang.bank import LangBank
from omnivat.kit.lines import lines

Record = dict[str, Any]  # of one run
FORMAT = "omnivat-run-2"
FORMATS = ("omnivat-run-1", FORMAT)  # 1: no odds, and "fused" is the chosen fusion


def fingerprint(embeddings: Embeddings) -> str:
    """Return a short hash of the content: vectors, labels, domains, splits and parts."""
    digest = blake2b(digest_size=8)
    for array in (embeddings.vis, embeddings.tac, embeddings.domain, embeddings.label):
        for block in walked(array):
            digest.update(block.tobytes())
    header = embeddings.header
    columns = [embeddings.rows[name] for name in ("object", "split", "part")]
    names = [header.key, header.domains, header.classes, columns, embeddings.vis_flip is not None]
    digest.update(json.dumps(names).encode())
    return digest.hexdigest()


def provenance(embeddings: Embeddings, bank: LangBank | None) -> Record:
    """Return the facts shared by all records of a file: data, text, versions."""
    header = embeddings.header
    return {
        "format": FORMAT,
        "data": {
            "encoder": header.encoder,
            "weights_hash": header.weights_hash,
            "preprocessing": header.preprocessing,
            "fingerprint": fingerprint(embeddings),
            "simulated": header.simulated,
            "origin": header.origin,
        },
        "lang": None if bank is None else {"origin": bank.origin, "hash": bank.hash},
        "versions": _versions(),
    }


def key(record: Mapping[str, Any]) -> str:
    """Return the key of a run, 16 hex digits: runs of equal method, settings, data and seed have
    the same key. Versions and times do not enter.
    """
    parts = [record[name] for name in ("method", "base", "settings", "source", "part", "seed")]
    parts += [record["data"]["fingerprint"], (record["lang"] or {}).get("hash", "")]
    text = json.dumps(parts, sort_keys=True)
    return blake2b(text.encode(), digest_size=8).hexdigest()


def append(path: Path, record: Mapping[str, Any]) -> None:
    """Append one line and flush it to disk."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as handle:
        handle.write(json.dumps(record, ensure_ascii=False) + "\n")
        handle.flush()
        os.fsync(handle.fileno())


def read(path: Path) -> list[Record]:
    """Return the records of a file, which may be compressed (.gz); an incomplete last line is
    ignored.

    Raises DataError with the line number for any other invalid line.
    """
    return list(lines(path, *FORMATS))


def mend(path: Path) -> None:
    """Remove an incomplete last line, so that lines can follow."""
    if path.is_file():
        os.truncate(path, path.read_bytes().rfind(b"\n") + 1)


def _versions() -> dict[str, str]:
    """Return versions, and the processor's instructions: they change the last bits of a
    training.
    """
    return {
        "python": platform.python_version(),
        "omnivat": __version__,
        "instructions": torch.backends.cpu.get_cpu_capability(),
        **{name: version(name) for name in ("torch", "numpy", "scipy")},
    }
