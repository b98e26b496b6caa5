"""Embeddings of a set of pairs: one `.safetensors` file with a checked header.

The file has arrays `vis`, `tac` (N, D), optional mirrored copies, the indices `domain` and `label`
(N,), and `rows`, the file and object names as UTF-8 JSON. The header names the encoder. Arrays are
memory-mapped, and torch is not needed.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open

from omnivat.data.arranged import ways_from
from omnivat.data.arrays import (
    MOST_COLUMNS,
    Column,
    column,
    read_arrays,
    released,
    require_range,
    walked,
    write_arrays,
)
from omnivat.data.domains import require_domain_names
from omnivat.data.embeddings import KEY, VECTORS, Array, Embeddings, Header
from omnivat.data.pairs import TEXTS
from omnivat.data.relief import Lamps
from omnivat.data.relief.files import packed, unpacked
from omnivat.kit.errors import DataError, WriteError
from omnivat.kit.files import path_of, replacing, write_csv
from omnivat.kit.schema import columns_in, json_in, name_list, object_in, texts
from omnivat.kit.stages import IMAGES
from omnivat.kit.tables import need, require_choice

FORMAT = "omnivat-embeddings-1"
ROW_NAMES = ("vis", "tac", *TEXTS)
_WANTED = (
    "and embeddings are wanted; of pictures, make them with `python -m omnivat embed {} --out"
    " SET.safetensors`."
)
MANIFESTS = ("csv", "parquet")
COLUMNS = ("domain", "material", *ROW_NAMES)
DTYPES = ("float32", "float16")
MOST_NAMES = 65_536  # domains or classes
MOST_LAMPS = 400  # domains with lamps
MOST_CELLS = 1_000_000  # domains times classes: entries of the table of counts

__all__ = ["FORMAT", "ROW_NAMES", "Embeddings", "Header", "load_embeddings", "save_embeddings"]


def save_embeddings(path: str | Path, embeddings: Embeddings, *, dtype: str = "float32") -> None:
    """Write the embeddings, completely or not at all, and a manifest.

    dtype   "float32", or "float16" for half the size and 3 digits

    Raises DataError when a value is not finite or too large for float16.

    >>> from tempfile import TemporaryDirectory
    >>> from omnivat import default_embeddings
    >>> digit = load_embeddings(default_embeddings()).in_domain("TQ-DIGIT-sim")
    >>> with TemporaryDirectory() as folder:
    ...     save_embeddings(Path(folder) / "digit.safetensors", digit)
    ...     len(load_embeddings(Path(folder) / "digit.safetensors")) == len(digit)
    True
    """
    vectors = embeddings.vectors
    if set(vectors) != set(VECTORS):
        vectors = {name: vectors[name] for name in IMAGES}
    columns = {
        name: Column(dtype=vector_type(dtype), shape=array.shape, blocks=walked(array))
        for name, array in vectors.items()
    }
    domain, label = embeddings.domain, embeddings.label
    write_columns(
        path, embeddings.header, columns, domain=domain, label=label, rows=embeddings.rows
    )


def write_columns(
    path: str | Path,
    header: Header,
    vectors: Mapping[str, Column],
    *,
    domain: NDArray[np.int64],
    label: NDArray[np.int64],
    rows: Mapping[str, Sequence[str]],
    manifest: str = "csv",
) -> None:
    """Write a set of embeddings block by block, completely or not at all.

    Raises DataError when a value is not finite or too large for float16, a domain is called "all",
    or a name is one that `load_embeddings` refuses.
    """
    require_domain_names(header.domains)
    for kind, given in (("domains", header.domains), ("classes", header.classes)):
        name_list([*given], kind, MOST_NAMES)
    columns = {
        name: replace(vector, blocks=_checked(path, name, vector))
        for name, vector in vectors.items()
    }
    columns |= {
        "domain": column(np.asarray(domain, np.int64)),
        "label": column(np.asarray(label, np.int64)),
        "rows": column(np.frombuffer(_written(path, rows), dtype=np.uint8)),
    }
    names = {
        "domain": [header.domains[index] for index in domain],
        "material": [header.classes[index] for index in label],
        **{name: rows[name] for name in ROW_NAMES},
    }
    with replacing(path) as temporary:
        write_arrays(temporary, columns, _metadata(header, *vectors["vis"].shape))
        write_manifest(Path(path), names, manifest)


def _written(path: str | Path, rows: Mapping[str, Sequence[str]]) -> bytes:
    try:
        return json.dumps(rows, ensure_ascii=False).encode()
    except UnicodeEncodeError as error:
        raise DataError(
            f"'{path}' was not written: the name"
            f" {error.object[max(0, error.start - 20) : error.end + 20]!a} holds bytes that are no"
            " text (UTF-8); rename that file."
        ) from error


def vector_type(dtype: str) -> np.dtype[Any]:
    """Return numpy's "float32" or "float16"; raises SettingsError for another."""
    require_choice("dtype", dtype, DTYPES)
    return np.dtype(dtype)


def _checked(path: str | Path, name: str, vector: Column) -> Iterator[NDArray[Any]]:
    limit = np.finfo(vector.dtype).max
    for block in require_range(vector.blocks, f"'{path}' was not written: {name}"):
        if not (np.abs(block) <= limit).all():
            raise DataError(
                f"'{path}' was not written: {name} holds values too large for float16; use float32."
            )
        yield block


def _metadata(header: Header, count: int, width: int) -> dict[str, str]:
    return {
        "format": FORMAT,
        **dict(zip(KEY, header.key, strict=True)),
        "precision": header.precision,
        **({"text_hash": header.text_hash} if header.text_hash else {}),
        "domains": json.dumps(header.domains),
        "classes": json.dumps(header.classes),
        "simulated": json.dumps(header.simulated),
        **({"modalities": "+".join(header.modalities)} if header.modalities != IMAGES else {}),
        **({"tac_rest": json.dumps(header.tac_rest)} if header.tac_rest else {}),
        **({"tac_way": json.dumps(header.tac_way)} if header.tac_way else {}),
        **_texts_of(header.lamps),
        "origin": header.origin,
        "pairs": str(count),
        "width": str(width),
    }


def load_embeddings(path: str | Path, *, large: int | None = None) -> Embeddings:
    """Open an embeddings file; large arrays stay memory-mapped.

    large  bytes up to which an array is writable in memory, without changing the file, and
           half-precision vectors become float32; None: 64 MB

    Larger arrays are read-only; those in half precision become float32 block by block, in `walked`
    and `Embeddings.select`.
    Raises DataError with the file name if it is missing, truncated or of another kind.

    >>> from omnivat import default_embeddings
    >>> pairs = load_embeddings(default_embeddings())
    >>> pairs.vis.shape == (len(pairs), pairs.width), pairs.header.encoder
    (True, 'efficientnet-lite0')
    >>> pairs.header.domains[0], pairs.header.classes[pairs.label[0]]
    ('TAG-sim', 'wood')
    """
    file = path_of(path)
    if not file.is_file():
        if file.is_dir():
            raise DataError(f"'{file}' is a folder, {_WANTED.format(file)}")
        raise DataError(
            f"No embeddings file at '{file}'. Make one with `python -m omnivat embed PAIRS --out"
            f" {file}`."
        )
    if file.suffix.lower() == ".csv":
        raise DataError(f"'{file}' is a table, {_WANTED.format(file)}")
    try:
        arrays, metadata = read_arrays(file, large=large)
        if metadata.get("format") != FORMAT:
            raise DataError(
                f"'{file}' is not a set of embeddings (format '{metadata.get('format', 'none')}', "
                f"expected '{FORMAT}'). Make one with `python -m omnivat embed`."
            )
        if arrays["rows"].dtype != np.uint8 or arrays["rows"].ndim != 1:
            raise DataError("'rows' should be the bytes of a JSON object; make the file again.")
        rows = columns_in(arrays["rows"].tobytes(), f"{file} (rows)", MOST_COLUMNS)
        embeddings = Embeddings(
            header=header_of(metadata),
            rows=rows,
            domain=arrays["domain"],
            label=arrays["label"],
            **{name: _single(arrays[name]) for name in VECTORS if name in arrays},
        )
    except DataError:
        raise
    except (SafetensorError, OSError, ValueError, KeyError, TypeError) as error:
        raise DataError(
            f"'{file}' cannot be read as embeddings ({error}). It may be cut short; make it again"
            " with `python -m omnivat embed`."
        ) from error
    _check(file, embeddings)
    return embeddings


def is_embeddings(file: Path) -> bool:
    """True for a safetensors file, but for another program's, which has another format or none."""
    if file.suffix.lower() != ".safetensors" or not file.is_file():
        return file.suffix.lower() == ".safetensors"
    try:
        with safe_open(file, framework="numpy") as handle:
            return (handle.metadata() or {}).get("format") == FORMAT
    except (SafetensorError, OSError):
        return True


def _single(array: NDArray[Any]) -> Array:
    if array.dtype not in (np.float32, np.float16):
        raise DataError(f"The embeddings are of type {array.dtype}, expected float32 or float16.")
    return array.astype(np.float32, copy=False) if array.flags.writeable else array


def header_of(metadata: Mapping[str, str]) -> Header:
    """Return the header in a file's texts. Raises DataError or KeyError for an invalid one."""
    return Header(
        encoder=metadata["encoder"],
        weights_hash=metadata["weights_hash"],
        preprocessing=metadata["preprocessing"],
        domains=name_list(json_in(metadata["domains"].encode(), "domains"), "domains", MOST_NAMES),
        classes=name_list(json_in(metadata["classes"].encode(), "classes"), "classes", MOST_NAMES),
        simulated=json_in(metadata["simulated"].encode(), "simulated") is True,
        origin=metadata["origin"],
        precision=metadata.get("precision", "fp32"),
        text_hash=metadata.get("text_hash", ""),
        modalities=tuple(
            m for m in IMAGES if m in metadata.get("modalities", "vis+tac").split("+")
        ),
        tac_rest={
            domain: name_list(hashes, "tac_rest", MOST_NAMES)
            for domain, hashes in object_in(metadata.get("tac_rest", "{}").encode(), "rest").items()
        },
        tac_way=ways_from(metadata.get("tac_way", "{}")),
        lamps=_lamps_of(metadata),
    )


def _texts_of(lamps: Mapping[str, Lamps | str]) -> dict[str, str]:
    """Return two entries of a header: lamps by domain, and reasons of domains without."""
    kept = {name: lamp for name, lamp in lamps.items() if isinstance(lamp, str)}
    lit = {name: packed(lamp) for name, lamp in lamps.items() if not isinstance(lamp, str)}
    entries = {"lamps": lit, "kept": kept}
    return {name: json.dumps(entry) for name, entry in entries.items() if entry}


def _lamps_of(metadata: Mapping[str, str]) -> dict[str, Lamps | str]:
    lit, kept = (texts(object_in(metadata.get(n, "{}").encode(), n), n) for n in ("lamps", "kept"))
    if len(lit) > MOST_LAMPS:  # each is a picture, which text holds in little room
        raise DataError(f"The lamps of {len(lit):,} domains are stated, and {MOST_LAMPS} are read.")
    return {**kept, **{name: unpacked(text) for name, text in lit.items()}}


def _check(file: Path, embeddings: Embeddings) -> None:
    header = embeddings.header
    require_domain_names(header.domains)
    if len(header.domains) * len(header.classes) > MOST_CELLS:
        raise DataError(
            f"'{file}' names {len(header.domains):,} domains and {len(header.classes):,} classes,"
            f" and their product may be {MOST_CELLS:,}; leave out names without pairs."
        )
    shape = embeddings.vis.shape
    flips = [a for a in (embeddings.vis_flip, embeddings.tac_flip) if a is not None]
    shapes_agree = (
        len(shape) == 2
        and shape[1] > 0
        and all(a.shape == shape for a in (embeddings.tac, *flips))
        and embeddings.domain.shape == embeddings.label.shape == shape[:1]
        and all(len(embeddings.rows.get(name, ())) == shape[0] for name in ROW_NAMES)
    )
    if not shapes_agree or not embeddings.domain.dtype == embeddings.label.dtype == np.int64:
        raise DataError(f"'{file}' holds arrays of differing lengths; make it again.")
    for name, names in (("domain", header.domains), ("label", header.classes)):
        index = getattr(embeddings, name)
        if len(index) and not (index.min() >= 0 and index.max() < len(names)):
            raise DataError(f"'{file}' has a {name} index without a name; make it again.")
    for vectors in (embeddings.vis, embeddings.tac, *flips):
        for _ in require_range(walked(vectors), f"'{file}'"):
            pass
        released(vectors)  # read, not changed


def write_manifest(path: Path, columns: Mapping[str, Sequence[str]], kind: str) -> None:
    """Write named columns of text next to `path`, completely or not at all.

    Raises SettingsError for an unknown kind, MissingPackageError for Parquet without pyarrow,
    WriteError if another table would be lost.
    """
    place = manifest_place(path, kind)
    require_own(place)
    if kind == "csv":
        write_csv(place, columns, zip(*columns.values(), strict=True))
        return
    pyarrow = need("pyarrow", purpose="a Parquet manifest")
    parquet = need("pyarrow.parquet", purpose="a Parquet manifest", install="pyarrow")
    with replacing(place) as temporary:
        parquet.write_table(pyarrow.table(dict(columns)), temporary)


def manifest_place(path: Path, kind: str) -> Path:
    """Return the path of the table next to `path`, before anything is computed.

    Raises SettingsError for an unknown kind, MissingPackageError for Parquet without pyarrow.
    """
    require_choice("manifest", kind, MANIFESTS)
    if kind == "parquet":
        need("pyarrow", purpose="a Parquet manifest")
    return path.with_suffix(f".{kind}")


def require_own(place: Path) -> None:
    """Raise WriteError if a CSV that is not a manifest would be replaced, such as a table of
    pairs.
    """
    if place.suffix != ".csv" or not place.is_file():
        return
    with place.open("rb") as handle:
        first = handle.readline(4096).decode("utf-8", "replace").strip()
    if first != ",".join(COLUMNS):
        raise WriteError(
            f"'{place}' is another table and would be replaced by that of the embeddings; "
            "choose another name for the embeddings, or move the table."
        )
