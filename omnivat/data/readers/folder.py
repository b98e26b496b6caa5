"""Folders of pictures called NAME_vis and NAME_tac, or in folders vis and tac:
<root>/<domain>/<class>/[<object>/]<name>_vis.png beside <name>_tac.png.
"""

import os
import re
from collections import defaultdict
from pathlib import Path

from omnivat.data.materials import MATERIALS, NO_CLASS, class_key
from omnivat.data.pairs import Pair, PairSet, Skipped
from omnivat.data.readers.files import (
    folders_in,
    is_image_name,
    is_text,
    modality_of,
    show,
    visible,
)
from omnivat.data.rest import REST
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES

HALF = re.compile(r"_(vis|tac)$", re.IGNORECASE)
LAYOUT = "<domain>/<class>/<name>_vis.png beside <name>_tac.png"


def recognises(source: Path) -> bool:
    """True for any folder; this reader is the last one tried."""
    return source.is_dir()


def read(source: Path, *, strict: bool = False, seed: int = 0) -> PairSet:
    """Return the pairs of a plain folder; of photos or touches alone, each stands for both.

    source  a folder with one folder for each domain
    strict  keep the five materials only
    seed    not used: every pair is kept

    Of the folders below `source`, the first names the domain, the second the class in lower case,
    the others the object, which no split divides. Missing ones give the name of `source`,
    "unlabelled" and no object; folders vis and tac do not count. A single image without its
    partner, and a duplicate, is skipped and listed.
    Raises DataError without pairs, or for two classes or domains of the same name.
    """
    pictures, skipped = _walked(source)
    alone = len({half for halves in pictures.values() for half in halves}) == 1
    pairs = []
    for (*parts, name), halves in pictures.items():
        material = class_key(parts[1]) if len(parts) > 1 else NO_CLASS
        if why := _why_not(halves, material, alone=alone, strict=strict):
            skipped.append(Skipped(what=show("/".join((*parts, name))), why=why))
            continue
        first, last = min(halves), max(halves)  # of both "tac" and "vis", of one the same
        pairs.append(
            Pair(
                vis=halves[last][0],
                tac=halves[first][0],
                domain=parts[0] if parts else source.resolve().name or "pictures",
                material=material,
                object=f"{material}/{'/'.join(parts[2:])}" if len(parts) > 2 else "",
            )
        )
    if not pairs:
        raise DataError(_no_pairs(source, skipped))
    return PairSet(
        pairs=tuple(pairs),
        skipped=tuple(skipped),
        origin=f"folder '{source.name or source}'" + (", one picture of each pair" * alone),
    )


Pictures = dict[tuple[str, ...], dict[str, list[Path]]]  # by folders and name, and modality


def _walked(root: Path) -> tuple[Pictures, list[Skipped]]:
    """Return the pictures in a folder and in those below it, and what was skipped."""
    pictures: Pictures = defaultdict(dict)
    skipped: list[Skipped] = []
    seen: set[str] = set()  # real folders; links may lead to them again

    def skip(path: Path, why: str) -> None:
        skipped.append(Skipped(what=show(path.relative_to(root)), why=why))

    def enter(folder: Path, *parts: str) -> None:
        """Read a folder; `parts` are its domain, class and object."""
        for entry in visible(folder):
            path = folder / entry.name
            half = modality_of(path)
            if path.is_dir() or path.name == REST or not (half or is_image_name(path.name)):
                continue
            if why := _no_picture(path, half):
                skip(path, why)
            else:
                halves = pictures[(*parts, HALF.sub("", path.stem))]
                halves.setdefault(half, []).append(path)
        inner = folders_in(folder)
        if len(parts) < 2:
            _require_names(inner, ("domains", "classes")[len(parts)])
        for child in inner:
            real = os.path.realpath(child)
            if real in seen or Path(os.path.realpath(root)).is_relative_to(real):
                skip(child, "leads to a folder that is read already")
            elif not os.access(child, os.R_OK | os.X_OK):
                skip(child, "may not be opened: its permissions forbid it")
            else:
                seen.add(real)
                name = child.name.strip()
                enter(child, *parts, *(() if name.lower() in IMAGES else (name,)))

    enter(root)
    return pictures, skipped


def _no_picture(path: Path, half: str) -> str:
    """Return why a file is not part of a pair, or ""."""
    if not is_text(str(path)):
        return "a name in its path is not UTF-8; rename it"
    if not half:
        return "its name ends neither in _vis nor in _tac"
    if not is_image_name(path.name):
        return f"'{show(path.suffix)}' is not a suffix of images"
    return "" if path.is_file() else "cannot be opened (a broken link?)"


def _why_not(halves: dict[str, list[Path]], material: str, *, alone: bool, strict: bool) -> str:
    """Return why pictures of one name give no pair, or ""."""
    if strict and material not in MATERIALS:
        return f"strict: not one of {', '.join(MATERIALS)}"
    for half, pictures in halves.items():
        if len(pictures) > 1:
            return f"{half} is there more than once: {' and '.join(show(p.name) for p in pictures)}"
    if len(halves) == 2 or alone:
        return ""
    return f"no {'_tac' if 'vis' in halves else '_vis'} image beside the other"


def _require_names(folders: list[Path], kind: str) -> None:
    """Raise DataError if two folders have the same name."""
    first: dict[str, Path] = {}
    for folder in folders:
        other = first.setdefault(class_key(folder.name), folder)
        if other != folder:
            raise DataError(
                f"Two {kind} of one name: '{show(other)}' and '{show(folder)}'. "
                "Put their pairs into one folder, or rename one."
            )


def _no_pairs(source: Path, skipped: list[Skipped]) -> str:
    if any((source / name).is_file() for name in ("meta/info.json", "videos.csv")):
        return (
            f"'{show(source)}' holds recordings; make pairs of them first: `python -m omnivat"
            f" import {show(source)} --out PAIRS`."
        )
    message = f"No pairs in '{show(source)}'; expected {LAYOUT}."
    if skipped:
        message += f" {len(skipped)} skipped, such as '{skipped[0].what}': {skipped[0].why}."
    return message
