"""Plain folders: <root>/<domain>/<class>/[<object>/]<name>_vis.png and <name>_tac.png, or such
names anywhere.
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
    leads_upwards,
    modality_of,
    show,
    visible,
)
from omnivat.data.rest import REST
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES

HALF = re.compile(r"(?P<name>.*)_(?P<half>vis|tac)", re.IGNORECASE | re.DOTALL)
LAYOUT = "<domain>/<class>/<name>_vis.png beside <name>_tac.png"


def recognises(source: Path) -> bool:
    """True for any folder; this reader is the last one tried."""
    return source.is_dir()


def read(source: Path, *, strict: bool = False, seed: int = 0) -> PairSet:
    """Return the pairs of a plain folder.

    source  a folder with one folder for each domain
    strict  keep the five materials only
    seed    not used: every pair is kept

    The class is the folder's name in lower case. A folder inside a class is an object, which no
    split divides. A single image without its partner, and a duplicate, is skipped and listed.
    Raises DataError without pairs, or for two classes or domains of the same name.
    """
    if not source.is_dir():
        raise DataError(f"'{show(source)}' is not a folder; expected a folder of {LAYOUT}.")
    walk = _Walk(source, strict)
    walk.enter(source)
    if not walk.pairs:
        raise DataError(_no_pairs(source, walk.skipped))
    return PairSet(
        pairs=tuple(walk.pairs),
        skipped=tuple(walk.skipped),
        origin=f"folder '{source.name or source}'",
    )


class _Walk:
    """The state of the walk through the folders."""

    def __init__(self, root: Path, strict: bool) -> None:
        self.root, self.strict = root, strict
        self.pairs: list[Pair] = []
        self.skipped: list[Skipped] = []
        self._seen: dict[str, Path] = {}  # real folder -> name at first visit

    def skip(self, path: Path, why: str) -> None:
        self.skipped.append(Skipped(what=show(path.relative_to(self.root)), why=why))

    def enter(self, folder: Path, *parts: str) -> None:
        """Read a folder and those below it; `parts` are its domain, class, object and more."""
        depth = len(parts)
        if depth == 2 and self.strict and class_key(parts[1]) not in MATERIALS:
            self.skip(folder, f"strict: not one of {', '.join(MATERIALS)}")
            return
        if depth in (2, 3):
            material = class_key(parts[1])
            thing = f"{material}/{parts[2]}" if depth == 3 else ""
            self._read_place(folder, parts[0], material, thing)
        elif depth:
            why = "lies in no class folder" if depth == 1 else "lies deeper than an object folder"
            for entry in filter(lambda entry: _is_half(entry.name), visible(folder)):
                self.skip(folder / entry.name, why)
        if depth > 3:
            return
        inner = folders_in(folder)
        if depth < 2:
            _require_names(inner, ("domains", "classes")[depth])
        for child in filter(self.is_new, inner):
            self.enter(child, *parts, child.name.strip())

    def is_new(self, folder: Path) -> bool:
        """True if a folder is visited for the first time; links may lead to it again."""
        real = os.path.realpath(folder)
        if leads_upwards(folder):
            self.skip(folder, "leads back to a folder that it lies in")
        elif not os.access(folder, os.R_OK | os.X_OK):
            self.skip(folder, "may not be opened: its permissions forbid it")
        elif real in self._seen:
            first = show(self._seen[real].relative_to(self.root))
            self.skip(folder, f"leads to the same folder as '{first}'")
        else:
            self._seen[real] = folder
            return True
        return False

    def _read_place(self, folder: Path, domain: str, material: str, thing: str) -> None:
        if not is_text(str(folder)):
            self.skip(folder, "the folder's name is not UTF-8; rename it")
            return
        halves: dict[str, dict[str, list[Path]]] = defaultdict(lambda: defaultdict(list))
        for entry in visible(folder):
            path = folder / entry.name
            stem = HALF.fullmatch(path.stem)
            if why := _not_a_half(path, stem):
                self.skip(path, why)
            elif stem:
                halves[stem["name"]][stem["half"].lower()].append(path)
        for name, found in halves.items():
            vis, tac = found["vis"], found["tac"]
            if len(vis) == len(tac) == 1:
                self.pairs.append(
                    Pair(vis=vis[0], tac=tac[0], domain=domain, material=material, object=thing)
                )
            elif not vis or not tac:
                self.skip(
                    folder / name, f"no {'_vis' if not vis else '_tac'} image beside the other"
                )
            else:
                files = " and ".join(show(path.name) for path in max(vis, tac, key=len))
                self.skip(folder / name, f"one half is there more than once: {files}")


def _not_a_half(path: Path, stem: re.Match[str] | None) -> str:
    """Return why a file is not part of a pair, or "". Files of other kinds are ignored."""
    if path.name == REST:
        return ""
    image = is_image_name(path.name)
    if not image and not stem:
        return ""
    if path.is_dir():
        return "a folder with the name of an image" if image else ""
    if not is_text(path.name):
        return "the file's name is not UTF-8; rename it"
    if not stem:
        return "its name ends neither in _vis nor in _tac"
    if not image:
        return f"'{show(path.suffix)}' is not a suffix of images"
    if not stem["name"]:
        return "its name is only _vis or _tac"
    return "" if path.is_file() else "cannot be opened (a broken link?)"


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
    for place in (source, *folders_in(source)):
        if any(_is_half(entry.name) for entry in visible(place)):
            return (
                f"{message} The images in '{show(place)}' lack a folder for their domain or class: "
                "add it, give the folder above, or name both in a pairs.csv."
            )
    if skipped:
        message += f" {len(skipped)} skipped, such as '{skipped[0].what}': {skipped[0].why}."
    return message


def _is_half(name: str) -> bool:
    return is_image_name(name) and HALF.fullmatch(Path(name).stem) is not None


def read_loose(source: Path, *, strict: bool = False, seed: int = 0) -> PairSet:
    """Return the pairs of a folder; if it holds photos or touches alone, each stands for both.

    A picture is called NAME_vis or NAME_tac, or lies in a folder vis or tac. Of the other folders
    below `source`, the first names the domain, the second the class, the third the object; missing
    ones give the name of `source`, "unlabelled" and no object.
    Raises DataError without such pictures, or with halves that never meet.
    """
    halves: dict[tuple[str, ...], dict[str, Path]] = defaultdict(dict)
    for path in sorted(source.rglob("*")):
        half = modality_of(path)
        if half and is_image_name(path.name) and is_text(str(path)):
            parts = [
                part for part in path.parent.relative_to(source).parts if part.lower() not in IMAGES
            ]
            match = HALF.fullmatch(path.stem)
            halves[(*parts, match["name"] if match else path.stem)].setdefault(half, path)
    alone = len({half for found in halves.values() for half in found}) == 1
    pairs, skipped = [], []
    for (*parts, _), found in halves.items():
        some = list(found.values())
        if len(some) == 2 or alone:
            material = class_key(parts[1]) if len(parts) > 1 else NO_CLASS
            pairs.append(
                Pair(
                    vis=found.get("vis", some[0]),
                    tac=found.get("tac", some[0]),
                    domain=parts[0] if parts else source.resolve().name or "pictures",
                    material=material,
                    object=f"{material}/{'/'.join(parts[2:])}" if len(parts) > 2 else "",
                )
            )
        else:
            skipped.append(Skipped(what=show(some[0].relative_to(source)), why="lacks its partner"))
    if not pairs:
        raise DataError(
            f"No pairs in '{show(source)}': name pictures NAME_vis.png and NAME_tac.png, in one"
            " folder, or put them into folders vis and tac."
        )
    return PairSet(
        pairs=tuple(pairs),
        skipped=tuple(skipped),
        origin=f"folder '{source.name}'" + (", one picture of each pair" if alone else ""),
    )
