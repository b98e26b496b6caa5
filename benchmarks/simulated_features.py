"""Unit-length embeddings of a simulated set, with their columns."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from omnivat.data.store import load_embeddings
from omnivat.encoders.base import DEFAULT_ENCODER
from omnivat.kit.errors import DataError

Array = NDArray[np.float32]
Names = NDArray[np.str_]
SHIPPED = Path("examples/simulated.safetensors")
_BATCH = 32
_KEPT = ("vis", "tac", "object", "split", "looks_like", "feels_like")


@dataclass(frozen=True, slots=True, kw_only=True)
class Features:
    """Unit-length embeddings of a set: (N, D) each, and a row of pairs.csv for each."""

    vis: Array
    tac: Array
    rows: list[dict[str, str]]

    def column(self, name: str) -> Names:
        """Return one column of pairs.csv."""
        return np.array([row.get(name, "") for row in self.rows])


def features_in(file: Path) -> Features:
    """Return the content of an embeddings file."""
    kept = load_embeddings(file)
    if not kept.header.encoder == DEFAULT_ENCODER:
        raise DataError(f"'{file}' holds {kept.header.encoder}; expected {DEFAULT_ENCODER}.")
    rows = [
        {
            "domain": kept.header.domains[kept.domain[index]],
            "material": kept.header.classes[kept.label[index]],
            **{name: kept.rows[name][index] for name in _KEPT},
        }
        for index in range(len(kept))
    ]
    return Features(vis=unit(kept.vis), tac=unit(kept.tac), rows=rows)


def features_of(pairs: Path) -> Features:
    """Return the embeddings of all images that `pairs/pairs.csv` lists."""
    table = pairs / "pairs.csv"
    if not table.exists():
        raise DataError(f"'{table}' is not there; make it with `python -m omnivat simulate`.")
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    vis = embedded([pairs / row["vis"] for row in rows])
    tac = embedded([pairs / row["tac"] for row in rows])
    return Features(vis=vis, tac=tac, rows=rows)


def unit(values: Array) -> Array:
    """Return vectors (N, D) of length 1."""
    wide = np.asarray(values, dtype=np.float32)
    return np.asarray(wide / np.linalg.norm(wide, axis=1, keepdims=True))


def embedded(files: list[Path]) -> Array:
    """Return the default encoder's embeddings of image files, each of unit length."""
    return unit(encoded(files))


def encoded(files: list[Path]) -> Array:
    """Return the default encoder's embeddings of image files as they are."""
    import torch

    from omnivat.data.images import read_image
    from omnivat.encoders.base import load_encoder

    encoder = load_encoder(DEFAULT_ENCODER)
    parts = []
    with torch.no_grad():
        for start in range(0, len(files), _BATCH):
            images = [encoder.preprocess(read_image(file)) for file in files[start : start + _BATCH]]
            parts.append(encoder.embed(torch.stack(images)).numpy())
    return np.asarray(np.concatenate(parts))
