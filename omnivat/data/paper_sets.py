"""Find the paper's data sets below one folder, and read them as one set."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import blake2b
from importlib import import_module
from pathlib import Path

from omnivat.data.pairs import PairSet
from omnivat.data.readers import READERS, read_pairs
from omnivat.data.readers.files import folders_in
from omnivat.kit.errors import DataError

# reader -> name of the set
SETS = {
    "touch_and_go": "Touch-and-Go",
    "objectfolder_real": "ObjectFolder Real",
    "objectfolder_2": "ObjectFolder 2.0",
    "tacquad": "TacQuad",
}
DEPTH = 2  # levels below the root that are searched


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperSets:
    """The result: reader -> folder, the pairs of each, and all pairs as one set."""

    places: Mapping[str, Path]
    parts: Mapping[str, PairSet]
    pairs: PairSet

    @property
    def missing(self) -> tuple[str, ...]:
        """The missing data sets of the paper."""
        return tuple(title for name, title in SETS.items() if name not in self.places)

    @property
    def fingerprint(self) -> str:
        """A hash of the list of pairs: files, names and splits."""
        rows = [
            [str(p.vis), str(p.tac), p.domain, p.material, p.split, p.part]
            for p in self.pairs.pairs
        ]
        return blake2b(json.dumps(rows).encode(), digest_size=8).hexdigest()


def find_paper_sets(root: Path) -> dict[str, Path]:
    """Return reader -> folder of each data set in `root` or up to two folders below it.

    Raises DataError if there is no such folder, no set in it, or one set twice.
    """
    if not root.is_dir():
        raise DataError(f"There is no folder '{root}'; name the one with the data sets in it.")
    found: dict[str, Path] = {}
    folders, level = [root], [root]
    for _ in range(DEPTH):
        level = [
            child for folder in level for child in folders_in(folder) if not child.is_symlink()
        ]
        folders += level  # breadth first
    for folder in folders:
        if any(folder != place and folder.is_relative_to(place) for place in found.values()):
            continue  # inside a set that was found
        for name in SETS:
            if import_module(READERS[name].split(":")[0]).recognises(folder):
                if name in found:
                    raise DataError(
                        f"{SETS[name]} is there twice, in '{found[name]}' and '{folder}'; keep one."
                    )
                found[name] = folder
                break
    if not found:
        raise DataError(
            f"None of {', '.join(SETS.values())} is in '{root}'; docs/reproduce.md lists where each"
            " is from and how it lies on disk."
        )
    return {name: found[name] for name in SETS if name in found}


def read_paper_sets(root: Path) -> PaperSets:
    """Read every data set of the paper in `root`, with the default options of its reader.

    ObjectFolder 2.0 counts as in the paper: its rendered touch is not marked as simulated.
    Raises DataError as `find_paper_sets` and the readers do.
    """
    places = find_paper_sets(root)
    parts = {name: read_pairs(place, reader=name) for name, place in places.items()}
    pairs = tuple(pair for part in parts.values() for pair in part.pairs)
    skipped = tuple(skip for part in parts.values() for skip in part.skipped)
    origin = "; ".join(part.origin or SETS[name] for name, part in parts.items())
    return PaperSets(
        places=places, parts=parts, pairs=PairSet(pairs=pairs, skipped=skipped, origin=origin)
    )
