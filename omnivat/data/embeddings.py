"""Embeddings of a set of pairs in memory: vectors, names, and a header with their origin."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.arrays import walked
from omnivat.data.materials import NO_CLASS
from omnivat.data.pairs import TEXTS, Pair, PairSet
from omnivat.kit.errors import DataError, ShapeError
from omnivat.kit.seeding import derive_seed
from omnivat.kit.stages import IMAGES

if TYPE_CHECKING:
    from omnivat.data.relief import Lamps

Array = NDArray[np.float32]
VECTORS = ("vis", "tac", "vis_flip", "tac_flip")
KEY = ("encoder", "weights_hash", "preprocessing")  # fields of `Header.key`


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """The origin of embeddings. Two files can be mixed only if their `key` is equal."""

    encoder: str
    weights_hash: str
    preprocessing: str
    domains: tuple[str, ...]
    classes: tuple[str, ...]
    simulated: bool = False
    origin: str = ""
    precision: str = "fp32"  # of the encoder
    text_hash: str = ""  # of the text tower in the encoder's checkpoint, if any
    # domain -> hashes of the no-contact pictures that were subtracted from its tactile images
    tac_rest: Mapping[str, Sequence[str]] = field(default_factory=dict)
    # domain -> how its touches were turned, and their channels swapped
    tac_way: Mapping[str, str] = field(default_factory=dict)
    modalities: tuple[str, ...] = IMAGES  # that every pair has; of one alone, it stands for both
    # domain -> the lamps by which its relief was drawn, or why each touch was drawn by itself
    lamps: "Mapping[str, Lamps | str]" = field(default_factory=dict)

    @property
    def key(self) -> tuple[str, str, str]:
        """The fields that must be equal for a comparison."""
        return self.encoder, self.weights_hash, self.preprocessing

    @property
    def lit_by(self) -> dict[str, int]:
        """Domain -> touches that gave the lamps of its relief: what was known of it."""
        lit = self.lamps.items()
        return {name: lamps.pictures for name, lamps in lit if not isinstance(lamps, str)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Embeddings:
    """Cached embeddings of N pairs and the names of everything in them.

    vis, tac            (N, D) from the encoder, any length; a large file's half precision stays
    vis_flip, tac_flip  (N, D) of the mirrored images, or None
    domain, label       (N,) indices into header.domains and header.classes
    rows                column name -> N texts: vis, tac (file names), object, split, part,
                        looks_like, feels_like (classes that a pair imitates, or "")

    Raises ShapeError for vectors of another kind, or of differing shapes.

    >>> from omnivat import EXAMPLES, load_embeddings
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> len(pairs), pairs.width, pairs.header.domains[0]
    (800, 64, 'Chirps A-sim')
    >>> source = pairs.in_domain("Chirps A-sim", split="train")
    >>> source.tac.shape, source.header.classes[source.label[0]]
    ((100, 64), 'chirp 1')
    """

    header: Header
    vis: Array
    tac: Array
    domain: NDArray[np.int64]
    label: NDArray[np.int64]
    rows: dict[str, list[str]]
    vis_flip: Array | None = None
    tac_flip: Array | None = None

    def __post_init__(self) -> None:
        shapes = {}
        for name in VECTORS:
            if (own := getattr(self, name)) is None and name not in ("vis", "tac"):
                continue
            if (
                not isinstance(own, np.ndarray)
                or own.ndim != 2
                or own.dtype not in (np.float16, np.float32, np.float64)
            ):
                came = type(own).__name__
                if isinstance(own, np.ndarray):
                    came = f"{own.shape} of {own.dtype}"
                raise ShapeError(
                    f"{name} should be a NumPy array (N, D) of floating-point numbers, not {came};"
                    " convert it first."
                )
            shapes[name] = own.shape
        if set(shapes.values()) != {(len(self.label), self.vis.shape[1])}:
            raise ShapeError(
                f"The arrays of {len(self.label)} pairs have differing lengths: {shapes}."
            )

    def __len__(self) -> int:
        return len(self.label)

    @property
    def vectors(self) -> dict[str, Array]:
        """The arrays of vectors that are there, by name."""
        return {name: array for name in VECTORS if (array := getattr(self, name)) is not None}

    @property
    def width(self) -> int:
        """D, the encoder's width."""
        return int(self.vis.shape[1])

    @property
    def labelled(self) -> NDArray[np.bool_]:
        """(N,) true for pairs with a class: `NO_CLASS` is the lack of one."""
        named: NDArray[np.bool_] = np.array(
            [name != NO_CLASS for name in self.header.classes], bool
        )[self.label]
        return named

    @property
    def objects(self) -> NDArray[np.int64]:
        """(N,) index of each pair's object by domain and name; a pair without a name is its own.

        Pairs of one object are not independent.
        """
        keys = [
            f"{self.header.domains[d]}/{name or f'{chr(0)}{k}'}"
            for k, (d, name) in enumerate(zip(self.domain, self.rows["object"], strict=True))
        ]
        return indices(sorted(set(keys)), keys)

    @property
    def unsplit(self) -> "Embeddings":
        """The same pairs without a split: all of a domain are there to learn and to test."""
        return replace(self, rows={**self.rows, "split": [""] * len(self)})

    @property
    def learnable(self) -> tuple[str, ...]:
        """Names of the domains with pairs of two classes or more, from which a head can learn."""
        there = np.zeros((len(self.header.domains), len(self.header.classes)), dtype=bool)
        there[self.domain, self.label] = self.labelled
        return tuple(n for n, own in zip(self.header.domains, there, strict=True) if own.sum() > 1)

    def select(self, keep: NDArray[Any]) -> "Embeddings":
        """Return the pairs of `keep`, a mask or indices; the list of domains stays the same."""
        index = np.flatnonzero(keep) if keep.dtype == bool else keep
        rows = {name: [column[i] for i in index] for name, column in self.rows.items()}
        vectors: dict[str, Any] = {
            name: _rows(array, index) for name, array in self.vectors.items()
        }
        return replace(
            self, **vectors, domain=self.domain[index], label=self.label[index], rows=rows
        )

    def sampled(self, count: int, *, seed: int = 0) -> "Embeddings":
        """Return `count` random pairs in their order, or all if there are fewer.

        The header's origin records the sampling. Names of domains and classes stay the same.
        """
        if not 0 < count < len(self):
            return self
        random = np.random.default_rng(derive_seed(seed, "sample", count))
        drawn = self.select(np.sort(random.choice(len(self), count, replace=False)))
        note = f"{count:,} of {len(self):,} pairs, drawn at random"
        origin = f"{self.header.origin}; {note}" if self.header.origin else note
        return replace(drawn, header=replace(self.header, origin=origin))

    def in_domain(self, name: str, *, split: str = "", part: str = "") -> "Embeddings":
        """Return the pairs of one domain, optionally of one split or part; see `rows_of`."""
        return self.select(self.rows_of(name, split=split, part=part))

    def rows_of(self, name: str, *, split: str = "", part: str = "") -> NDArray[np.int64]:
        """Return the rows of one domain, optionally of one split or part, ascending.

        If the data have no split ("" in every row), all pairs are kept. Raises DataError if the set
        lacks the domain.
        """
        if name not in self.header.domains:
            known = ", ".join(self.header.domains)
            raise DataError(f"No domain is called '{name}' in these embeddings; there are {known}.")
        keep = self.domain == self.header.domains.index(name)
        for column, wanted in (("split", split), ("part", part)):
            if wanted:
                values = np.array(self.rows[column], dtype=object)
                keep = keep & (values == wanted) if any(values[keep]) else keep
        return np.flatnonzero(keep)


def pairs_of(embeddings: Embeddings) -> PairSet:
    """Return the names of a set of embeddings as those of pairs, for its summary."""
    header = embeddings.header
    rows: dict[str, Any] = embeddings.rows
    alone = "".join(header.modalities) if len(header.modalities) == 1 else ""
    return PairSet(
        pairs=tuple(
            Pair(
                vis=Path(rows["vis"][k]),
                tac=Path(rows["tac"][k]),
                domain=header.domains[domain],
                material=header.classes[label],
                alone=alone,
                **{name: rows[name][k] for name in TEXTS},
            )
            for k, (domain, label) in enumerate(
                zip(embeddings.domain, embeddings.label, strict=True)
            )
        ),
        origin=header.origin.removeprefix("imported from "),
        simulated=header.simulated,
    )


def indices(names: Sequence[str], values: Sequence[str]) -> NDArray[np.int64]:
    """Return the index (N,) of each value among names."""
    place = {name: index for index, name in enumerate(names)}
    return np.array([place[value] for value in values], np.int64)


def _rows(array: Array, index: NDArray[Any]) -> Array:
    chosen: Array = np.empty((len(index), *array.shape[1:]), np.float32)
    start = 0
    for block in walked(array, index):
        chosen[start : start + len(block)] = block
        start += len(block)
    return chosen
