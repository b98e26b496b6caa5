"""Read features of any encoder, with one or two modalities, with or without classes and domains."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.data.embeddings import Embeddings
from omnivat.data.foreign import import_embeddings
from omnivat.data.materials import NO_CLASS
from omnivat.data.store import is_embeddings, load_embeddings
from omnivat.kit.errors import DataError
from omnivat.kit.files import path_of
from omnivat.measure.gaps.unit import unit

READINGS = {"vis": "vis", "tac": "tac", "both": "fused"}  # of linear maps and heads, by view
MOST = 4000  # pairs; more are drawn at random, and the report states it


@dataclass(frozen=True, slots=True, kw_only=True)
class Features:
    """N pairs, and which of modalities and labels they have."""

    embeddings: Embeddings
    modalities: tuple[str, ...]
    labelled: bool
    drawn_of: int  # pairs of the file

    @property
    def domains(self) -> list[str]:
        """Names of the domains with pairs."""
        sizes = np.bincount(self.embeddings.domain, minlength=len(self.embeddings.header.domains))
        return [n for n, size in zip(self.embeddings.header.domains, sizes, strict=True) if size]

    @property
    def views(self) -> list[str]:
        """The readings of a set: one modality, or each alone and both."""
        return [*self.modalities, *["both"] * (len(self.modalities) > 1)]

    def rows(self, modality: str) -> Tensor:
        """Return unit rows (N, D) of a modality."""
        return unit(torch.from_numpy(np.array(getattr(self.embeddings, modality), np.float32)))

    def members(self, domain: str) -> NDArray[np.int64]:
        """Return the rows of a domain."""
        return np.flatnonzero(
            self.embeddings.domain == self.embeddings.header.domains.index(domain)
        )


def read_features(
    file: str | Path,
    *,
    encoder: str = "",
    domain: str = "",
    classes: tuple[str, ...] = (),
    columns: Mapping[str, str] | None = None,
    simulated: bool = False,
    numbers: Sequence[str] = (),
    seed: int = 0,
) -> Features:
    """Return the features in an embeddings file, NPZ, Parquet, HDF5, safetensors or CSV.

    columns  name here -> name in the file, as for `omnivat import`; `vis` or `tac` may be absent,
             as may `material` and `domain`
    numbers  columns of numbers to keep, such as a force; an embeddings file has its own
    Raises DataError, one sentence with the file and the fault.

    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "mine.npz"
    ...     np.savez(file, tac=np.eye(4), domain=["A", "A", "B", "B"])
    ...     mine = read_features(file, encoder="my encoder")
    >>> mine.domains, mine.modalities, mine.labelled
    (['A', 'B'], ('tac',), False)
    """
    file = path_of(file)
    if file.is_dir() or is_embeddings(file):
        data = load_embeddings(file)
    else:
        data = import_embeddings(
            file,
            encoder=encoder or file.stem,
            domain=domain or file.stem,
            material=NO_CLASS,
            classes=classes or None,
            columns=columns,
            simulated=simulated,
            numbers=numbers,
        )
    found = features_of(data, seed=seed)
    if found.drawn_of < 2:
        raise DataError(f"'{file}' has {found.drawn_of} pair(s); 2 or more are needed.")
    return found


def features_of(data: Embeddings, *, seed: int = 0) -> Features:
    """Return the features of a set that is loaded; see `read_features`."""
    return Features(
        embeddings=data.sampled(MOST, seed=seed),
        modalities=data.header.modalities,
        labelled=len(np.unique(data.label)) > 1,
        drawn_of=len(data),
    )
