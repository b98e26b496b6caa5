"""A readable table next to a set of embeddings: CSV, or Parquet on request."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from omnivat.errors import SettingsError, WriteError
from omnivat.files import replacing, write_csv
from omnivat.tables import need

MANIFESTS = ("csv", "parquet")
_EARLIER = ("domain", "material", "vis", "tac", "object", "split", "part")
COLUMNS = (*_EARLIER, "looks_like", "feels_like")


def write_manifest(path: Path, columns: Mapping[str, Sequence[str]], kind: str = "csv") -> Path:
    """Write named columns of text next to `path`, completely or not at all; return the file's path.

    Raises SettingsError for an unknown kind, MissingPackageError for Parquet without pyarrow,
    WriteError if another table would be lost.
    """
    place = manifest_place(path, kind)
    require_own(place)
    if kind == "parquet":
        with replacing(place) as temporary:
            _write_parquet(temporary, columns)
    else:
        write_csv(place, columns, zip(*columns.values(), strict=True))
    return place


def manifest_place(path: Path, kind: str) -> Path:
    """Return the path of the table next to `path`. Raises SettingsError for an unknown kind."""
    if kind not in MANIFESTS:
        raise SettingsError(f"manifest is '{kind}'; choose {' or '.join(MANIFESTS)}.")
    return path.with_suffix(f".{kind}")


def require_own(place: Path) -> None:
    """Raise WriteError if a CSV that is not a manifest would be replaced, such as a table of pairs."""
    if place.suffix != ".csv" or not place.is_file():
        return
    with place.open("rb") as handle:
        first = handle.readline(4096).decode("utf-8", "replace").strip()
    if first not in (",".join(COLUMNS), ",".join(_EARLIER)):
        raise WriteError(
            f"'{place}' is another table and would be replaced by that of the embeddings; "
            "choose another name for the embeddings, or move the table."
        )


def _write_parquet(path: Path, columns: Mapping[str, Sequence[str]]) -> None:
    pyarrow = need("pyarrow", purpose="a Parquet manifest")
    parquet = need("pyarrow.parquet", purpose="a Parquet manifest", install="pyarrow")
    table = pyarrow.table({name: list(values) for name, values in columns.items()})
    parquet.write_table(table, path)
