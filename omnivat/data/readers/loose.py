"""Pictures in any folders by name alone: NAME_vis.* and NAME_tac.*, one of the two, no classes needed."""

from collections import defaultdict
from pathlib import Path

from omnivat.data.domains import is_simulated
from omnivat.data.materials import NO_CLASS, class_key
from omnivat.data.pairs import Pair, PairSet, Skipped
from omnivat.data.readers.folder import HALF
from omnivat.data.readers.names import is_image_name, is_text, show
from omnivat.errors import DataError


def recognises(source: Path) -> bool:
    """False: `folder` takes every folder, and this reader is named."""
    return False


def read(source: Path, *, strict: bool = False, seed: int = 0) -> PairSet:
    """Return the pairs of a folder; if it holds photos or touches alone, each stands for both.

    The first folder below `source` names the domain, the second the class, the third the object;
    missing ones give the name of `source`, "unlabelled" and no object.
    Raises DataError without pictures named *_vis or *_tac, or with halves that never meet.
    """
    halves: dict[tuple[Path, str], dict[str, Path]] = defaultdict(dict)
    for path in sorted(source.rglob("*")):
        match = HALF.fullmatch(path.stem)
        if match and is_image_name(path.name) and is_text(str(path)):
            halves[path.parent, match["name"]].setdefault(match["half"].lower(), path)
    alone = len({half for found in halves.values() for half in found}) == 1
    pairs, skipped = [], []
    for (folder, _), found in halves.items():
        some = list(found.values())
        if len(some) == 2 or alone:
            pairs.append(_pair(source, folder, found.get("vis", some[0]), found.get("tac", some[0])))
        else:
            skipped.append(Skipped(what=show(some[0].relative_to(source)), why="lacks its partner"))
    if not pairs:
        raise DataError(f"No pairs in '{show(source)}': name pictures NAME_vis.png and NAME_tac.png, in one folder.")
    return PairSet(
        pairs=tuple(pairs),
        skipped=tuple(skipped),
        origin=f"folder '{source.name}'" + (", one picture of each pair" if alone else ""),
        simulated=any(is_simulated(pair.domain) for pair in pairs),
    )


def _pair(source: Path, folder: Path, vis: Path, tac: Path) -> Pair:
    parts = folder.relative_to(source).parts
    material = class_key(parts[1]) if len(parts) > 1 else NO_CLASS
    return Pair(
        vis=vis,
        tac=tac,
        domain=parts[0] if parts else source.resolve().name or "pictures",
        material=material,
        object=f"{material}/{'/'.join(parts[2:])}" if len(parts) > 2 else "",
    )
