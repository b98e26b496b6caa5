"""Embeddings of a set of pairs: one `.safetensors` file with a checked header.

The file holds float arrays `vis`, `tac` (N, D), their flipped copies where made, the indices
`domain` and `label` (N,), and `rows`, the file and object names as UTF-8 JSON. The header says
which encoder made them. Arrays are memory-mapped; nothing here needs torch.
"""

import csv
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

from omnivat.errors import DataError
from omnivat.files import replacing

FORMAT = "omnivat-embeddings-1"
ROW_NAMES = ("vis", "tac", "object", "split", "part")
Array = NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """Where embeddings come from. Two files can be mixed only where `key` is the same."""

    encoder: str
    weights_hash: str
    preprocessing: str
    domains: tuple[str, ...]
    classes: tuple[str, ...]
    simulated: bool = False
    origin: str = ""

    @property
    def key(self) -> tuple[str, str, str]:
        """What must agree before embeddings can be compared."""
        return self.encoder, self.weights_hash, self.preprocessing


@dataclass(frozen=True, slots=True, kw_only=True)
class Embeddings:
    """Cached embeddings of N pairs and the names of everything in them.

    vis, tac            (N, D) as the encoder gave them, any length
    vis_flip, tac_flip  (N, D) of the mirrored images, or None where they were not made
    domain, label       (N,) indices into header.domains and header.classes
    rows                column name -> N texts: vis, tac (file names), object, split, part
    """

    header: Header
    vis: Array
    tac: Array
    domain: NDArray[np.int64]
    label: NDArray[np.int64]
    rows: dict[str, list[str]]
    vis_flip: Array | None = None
    tac_flip: Array | None = None

    def __len__(self) -> int:
        return len(self.label)

    @property
    def width(self) -> int:
        """D, the encoder's width."""
        return int(self.vis.shape[1])

    def select(self, keep: NDArray[Any]) -> "Embeddings":
        """Return the pairs that `keep`, a mask or indices, names; names of domains stay."""
        index = np.flatnonzero(keep) if keep.dtype == bool else keep
        return replace(
            self,
            vis=self.vis[index],
            tac=self.tac[index],
            domain=self.domain[index],
            label=self.label[index],
            vis_flip=None if self.vis_flip is None else self.vis_flip[index],
            tac_flip=None if self.tac_flip is None else self.tac_flip[index],
            rows={name: [column[i] for i in index] for name, column in self.rows.items()},
        )

    def in_domain(self, name: str, *, split: str = "", part: str = "") -> "Embeddings":
        """Return the pairs of one domain, of one split or part where named.

        A split that the data do not state ("" in every row) keeps all pairs.
        Raises DataError when no such domain is in the set.
        """
        if name not in self.header.domains:
            known = ", ".join(self.header.domains)
            raise DataError(f"No domain is called '{name}' in these embeddings; there are {known}.")
        keep = self.domain == self.header.domains.index(name)
        for column, wanted in (("split", split), ("part", part)):
            values = np.array(self.rows[column], dtype=object)
            if wanted and any(values[keep]):
                keep = keep & (values == wanted)
        return self.select(keep)


def save_embeddings(path: str | Path, embeddings: Embeddings) -> None:
    """Write the embeddings whole or not at all, and a readable `.csv` manifest beside them."""
    header = embeddings.header
    metadata = {
        "format": FORMAT,
        "encoder": header.encoder,
        "weights_hash": header.weights_hash,
        "preprocessing": header.preprocessing,
        "domains": json.dumps(header.domains),
        "classes": json.dumps(header.classes),
        "simulated": json.dumps(header.simulated),
        "origin": header.origin,
        "pairs": str(len(embeddings)),
        "width": str(embeddings.width),
    }
    rows = json.dumps(embeddings.rows, ensure_ascii=False).encode()
    arrays: dict[str, NDArray[Any]] = {
        "vis": embeddings.vis,
        "tac": embeddings.tac,
        "domain": embeddings.domain,
        "label": embeddings.label,
        "rows": np.frombuffer(rows, dtype=np.uint8),
    }
    if embeddings.vis_flip is not None and embeddings.tac_flip is not None:
        arrays |= {"vis_flip": embeddings.vis_flip, "tac_flip": embeddings.tac_flip}
    arrays = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    with replacing(path) as temporary:
        save_file(arrays, temporary, metadata=metadata)
    with replacing(Path(path).with_suffix(".csv")) as temporary:
        _write_manifest(temporary, embeddings)


def _write_manifest(path: Path, embeddings: Embeddings) -> None:
    with path.open("w", newline="", encoding="utf-8") as handle:
        writer = csv.writer(handle)
        writer.writerow(["domain", "material", *ROW_NAMES])
        header = embeddings.header
        columns = [embeddings.rows[name] for name in ROW_NAMES]
        for domain, label, *names in zip(
            embeddings.domain, embeddings.label, *columns, strict=True
        ):
            writer.writerow([header.domains[domain], header.classes[label], *names])


def load_embeddings(path: str | Path) -> Embeddings:
    """Open a file that `save_embeddings` wrote; big arrays stay memory-mapped.

    Raises DataError, naming the file, when it is missing, cut short or of another kind.
    """
    file = Path(path)
    if not file.is_file():
        raise DataError(
            f"No embeddings file at '{file}'. Make one with `python -m omnivat embed PAIRS --out {file}`."
        )
    try:
        with safe_open(file, framework="numpy") as handle:
            metadata = handle.metadata() or {}
            if metadata.get("format") != FORMAT:
                raise DataError(
                    f"'{file}' is not a set of embeddings (format '{metadata.get('format', 'none')}', "
                    f"wanted '{FORMAT}'). Make one with `python -m omnivat embed`."
                )
            arrays = {name: handle.get_tensor(name) for name in handle.keys()}  # noqa: SIM118
        header = _header(metadata)
        rows = json.loads(arrays.pop("rows").tobytes())
        embeddings = Embeddings(header=header, rows=rows, **arrays)
    except (SafetensorError, OSError, ValueError, KeyError, TypeError) as error:
        if isinstance(error, DataError):
            raise
        raise DataError(
            f"'{file}' cannot be read as embeddings ({error}). It may be cut short; make it again with "
            "`python -m omnivat embed`."
        ) from error
    _check(file, embeddings)
    return embeddings


def _header(metadata: dict[str, str]) -> Header:
    return Header(
        encoder=metadata["encoder"],
        weights_hash=metadata["weights_hash"],
        preprocessing=metadata["preprocessing"],
        domains=tuple(json.loads(metadata["domains"])),
        classes=tuple(json.loads(metadata["classes"])),
        simulated=json.loads(metadata["simulated"]),
        origin=metadata["origin"],
    )


def _check(file: Path, embeddings: Embeddings) -> None:
    count, width = embeddings.vis.shape if embeddings.vis.ndim == 2 else (-1, -1)
    flips = [a for a in (embeddings.vis_flip, embeddings.tac_flip) if a is not None]
    shapes_agree = (
        count >= 0
        and all(a.shape == (count, width) for a in (embeddings.tac, *flips))
        and embeddings.domain.shape == embeddings.label.shape == (count,)
        and all(len(embeddings.rows.get(name, ())) == count for name in ROW_NAMES)
    )
    if not shapes_agree:
        raise DataError(f"'{file}' holds arrays of differing lengths; make it again.")
    for name, index, names in (
        ("domain", embeddings.domain, embeddings.header.domains),
        ("label", embeddings.label, embeddings.header.classes),
    ):
        if count and not (index.min() >= 0 and index.max() < len(names)):
            raise DataError(f"'{file}' has a {name} index without a name; make it again.")
    if not all(np.isfinite(a).all() for a in (embeddings.vis, embeddings.tac, *flips)):
        raise DataError(f"'{file}' holds NaN or infinite embeddings; embed the pairs again.")
