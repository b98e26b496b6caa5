"""Read files of JSON lines, plain or gzipped."""

import gzip
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from omnivat.kit.errors import DataError


def lines(path: Path, *kinds: str) -> Iterator[dict[str, Any]]:
    """Yield the objects of a file of JSON lines of these formats; nothing if there is no file.

    Raises DataError as `read` does.
    """
    if not path.is_file():
        return
    content = path.read_bytes()
    found = (gzip.decompress(content) if path.suffix == ".gz" else content).decode().split("\n")
    for number, line in enumerate(found, start=1):
        if not line.strip():
            continue
        try:
            record = json.loads(line)
        except ValueError as error:
            if number == len(found):  # no line end: writing was interrupted
                return
            raise DataError(f"Line {number} of '{path}' is not JSON; remove it.") from error
        if not isinstance(record, dict) or record.get("format") not in kinds:
            raise DataError(f"Line {number} of '{path}' is not a record of a run ('{kinds[-1]}').")
        yield record
