"""Folders of pictures called NAME_vis and NAME_tac, or in folders of photos and of touches:
<root>/<domain>/<class>/[<object>/]<name>_vis.png beside <name>_tac.png.
"""

import os
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from omnivat.data.materials import MATERIALS, NO_CLASS, class_key
from omnivat.data.naming import (
    TACTILE,
    VIDEOS,
    composed,
    half_of,
    halves_among,
    is_image_name,
    modality_of,
    set_name,
    split_of,
    splits_within,
    without_half,
)
from omnivat.data.pairs import Pair, PairSet, Skipped
from omnivat.data.readers.files import TABLES, folders_in, is_text, show, visible
from omnivat.data.rest import REST
from omnivat.kit.errors import DataError
from omnivat.kit.stages import IMAGES

WORDS = {"vis": "photos", "tac": "touches"}
NO_WORD = "its name ends neither in _vis nor in _tac"
LAYOUT = "<domain>/<class>/<name>_vis.png beside <name>_tac.png"


class Place(NamedTuple):
    """What the folders above some pictures tell."""

    names: tuple[str, ...] = ()  # of domain, class and object
    half: str = ""
    split: str = ""
    leading: bool = False  # the first folder is a split's or a modality's


def recognises(source: Path) -> bool:
    """True for any folder; this reader is the last one tried."""
    return source.is_dir()


def read(
    source: Path, *, strict: bool = False, seed: int = 0, vis: str = "", tac: str = ""
) -> PairSet:
    """Return the pairs of a plain folder; of photos or touches alone, each stands for both.

    source    a folder with one folder for each domain
    strict    keep the five materials only
    seed      not used: every pair is kept
    vis, tac  names of the folders of photos and of touches; "": vis and tac, or two folders side
              by side whose words tell, such as rgb and gelsight

    Of the folders below `source`, the first names the domain, the second the class in lower case,
    the others the object, which no split divides. Missing ones give the name of `source`,
    "unlabelled" and no object. Folders of photos and touches do not count, nor do train, val and
    test, which are splits; below one of these, a single folder names the class. Nor does the word
    of a split at an end of a name, such as wood_train beside wood_test.
    A single image without its partner, and a duplicate, is left out and listed.
    Raises DataError without pairs, for two classes or domains of the same name, and for a split
    beside a domain.
    """
    pictures, skipped = _walked(source, {vis.casefold(): "vis", tac.casefold(): "tac"})
    pictures, how = _by_number(pictures)
    alone = {half for halves in pictures.values() for half in halves}
    only = alone.pop() if len(alone) == 1 else ""
    pairs = []
    for (place, name), halves in pictures.items():
        domain, group, *things = (
            *[""] * (place.leading and len(place.names) == 1),
            *place.names,
            "",
            "",
        )
        material = class_key(group) or NO_CLASS
        if why := _why_not(halves, material, alone=bool(only), strict=strict):
            what = "/".join(filter(None, (place.split, *place.names, name)))
            skipped.append(Skipped(what=show(what), why=why))
            continue
        first, last = min(halves), max(halves)  # of both "tac" and "vis", of one the same
        thing = "/".join(filter(None, things))
        pairs.append(
            Pair(
                vis=halves[last][0],
                tac=halves[first][0],
                domain=domain or set_name(source.resolve()),
                material=material,
                object=f"{material}/{thing}" if thing else "",
                split=place.split,
                alone=only,
            )
        )
    if not pairs:
        raise DataError(_no_pairs(source, skipped))
    if only:
        _require_no_others(only, skipped)
    return PairSet(
        pairs=tuple(pairs),
        skipped=tuple(skipped),
        origin=f"folder '{source.name or source}'{how}"
        + (", one picture of each pair" * bool(only)),
    )


Pictures = dict[tuple[Place, str], dict[str, list[Path]]]  # by place and name, and modality


def _walked(root: Path, named: dict[str, str]) -> tuple[Pictures, list[Skipped]]:
    """Return the pictures in a folder and in those below it, and what was skipped."""
    pictures: Pictures = defaultdict(dict)
    skipped: list[Skipped] = []
    seen: set[str] = set()  # real folders; links may lead to them again

    def skip(path: Path, why: str) -> None:
        skipped.append(Skipped(what=show(path.relative_to(root)), why=why))

    def enter(folder: Path, place: Place) -> None:
        for entry in visible(folder):
            path = folder / entry.name
            half = place.half or modality_of(path)
            if path.is_dir() or path.name == REST or not (half or is_image_name(path.name)):
                continue
            if why := _no_picture(path, half):
                skip(path, why)
            else:
                name = without_half(path.stem)
                pictures[place._replace(half=""), name].setdefault(half, []).append(path)
        inner = folders_in(folder)
        halves = _halves(inner, named)
        others = [child for child in inner if child.name not in halves]
        splits = _splits(others, top=not place.names)
        within = splits_within(child.name for child in others if child.name not in splits)
        if len(place.names) < 2:
            _require_names(
                [child for child in others if child.name not in {**splits, **within}],
                ("domains", "classes")[len(place.names)],
            )
        for child in inner:
            real = os.path.realpath(child)
            if real in seen or Path(os.path.realpath(root)).is_relative_to(real):
                skip(child, "leads to a folder that is read already")
            elif not os.access(child, os.R_OK | os.X_OK):
                skip(child, "may not be opened: its permissions forbid it")
            else:
                seen.add(real)
                name, leading = child.name, place.leading or not place.names
                if name in halves:
                    enter(child, place._replace(half=halves[name], leading=leading))
                elif name in splits:
                    enter(child, place._replace(split=splits[name], leading=leading))
                else:
                    name, split = within.get(name, (name, place.split))
                    names = (*place.names, composed(name.strip()))
                    leading = leading if split != place.split else place.leading
                    enter(child, place._replace(names=names, split=split, leading=leading))

    enter(root, Place())
    return pictures, skipped


def _by_number(pictures: Pictures) -> tuple[Pictures, str]:
    """Return pictures whose names never agree by the numbers at their ends, such as img_01 and
    gel_01, and words on it; the pictures as they are if each half has more than one wording.
    """
    ends = {key: re.fullmatch(r"(.*?)(\d+)", key[1]) for key in pictures}
    wordings: dict[str, set[str]] = defaultdict(set)
    merged: Pictures = defaultdict(dict)
    for key, halves in pictures.items():
        end = ends[key]
        if len(halves) > 1 or end is None:
            return pictures, ""
        for half, files in halves.items():
            wordings[half].add(end[1])
            merged[key[0], str(int(end[2]))].setdefault(half, []).extend(files)
    if len(wordings) < 2 or any(len(found) > 1 for found in wordings.values()):
        return pictures, ""
    return merged, ", paired by number"


def _halves(folders: list[Path], named: dict[str, str]) -> dict[str, str]:
    """Return the modality of each folder that holds one: those named, those called vis and tac,
    and two side by side whose words tell.
    """
    known = named if any(named) else dict(zip(IMAGES, IMAGES, strict=True))
    found = {f.name: known[low] for f in folders if (low := f.name.strip().casefold()) in known}
    words = halves_among(folder.name for folder in folders)
    if not found and not any(named) and len(words["vis"]) == len(words["tac"]) == 1:
        found = {words[half][0]: half for half in IMAGES}
    return found


def _splits(folders: list[Path], *, top: bool) -> dict[str, str]:
    """Return the split of each folder that is one's; a class may be called "train" beside others.

    Raises DataError if a split lies beside domains.
    """
    found = {folder.name: split for folder in folders if (split := split_of(folder.name))}
    others = [folder for folder in folders if folder.name not in found]
    if not found or not any(map(_has_pictures, others)):
        return found
    if not top:
        return {}
    raise DataError(
        f"Is '{show(next(iter(found)))}' beside '{show(others[0].name)}' a split or a domain? Put"
        f" the pairs of a split into folders train, val and test alone, or rename the domain."
    )


def _has_pictures(folder: Path) -> bool:
    return any(is_image_name(entry.name) for entry in visible(folder)) or any(
        map(_has_pictures, (child for child in folders_in(folder) if not child.is_symlink()))
    )


def _require_no_others(name: str, skipped: list[Skipped]) -> None:
    """Raise DataError if the set is of one modality, and pictures of the other one are left out."""
    for lost in skipped:
        half = half_of(Path(lost.what).stem)
        if lost.why == NO_WORD and half in IMAGES and half != name:
            raise DataError(
                f"'{lost.what}' has a word of {WORDS[half]} inside its name, so that only"
                f" {WORDS[name]} are left; begin or end the name with that word, or put photos and"
                " touches into folders named with --vis and --tac."
            )


def _no_picture(path: Path, half: str) -> str:
    """Return why a file is not part of a pair, or ""."""
    if not is_text(str(path)):
        return "a name in its path is not UTF-8; rename it"
    if not half:
        return NO_WORD
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
        if composed(other.name) != composed(folder.name):
            raise DataError(
                f"Two {kind} of one name: '{show(other)}' and '{show(folder)}'. "
                "Put their pairs into one folder, or rename one."
            )


def _films(folder: Path) -> Iterator[Path]:
    """Yield the recordings in a folder and below."""
    for entry in visible(folder):
        if entry.name.lower().endswith((*VIDEOS, *TACTILE)):
            yield folder / entry.name
    for child in folders_in(folder):
        if not child.is_symlink():
            yield from _films(child)


def _no_pairs(source: Path, skipped: list[Skipped]) -> str:
    make = f"`python -m omnivat import {show(source)} --out PAIRS`"
    known = (*TABLES, *TACTILE)
    film = next(_films(source), None)
    if any((source / name).is_file() for name in ("meta/info.json", "videos.csv")) or (
        film and any(entry.name.lower().endswith(known) for entry in visible(source))
    ):
        return f"'{show(source)}' holds recordings; make pairs of them first: {make}."
    if film:
        return (
            f"'{show(source)}' holds films, such as '{show(film.relative_to(source))}', and no"
            " table that names them. Write videos.csv there, with a row for each recording and the"
            f" columns vis or tac (files), material and object; then {make}."
        )
    if any(entry.name.endswith(".arrow") for entry in visible(source)):
        return (
            f"'{show(source)}' is a set that `datasets` saved; write it with"
            " datasets.load_from_disk(FOLDER).to_parquet(FILE), and import that file."
        )
    halves = halves_among(folder.name for folder in folders_in(source))
    named = [show(name) for half in (*IMAGES, "?") for name in halves[half]]
    perhaps = f" (perhaps {', '.join(named)})" if named else ""
    message = (
        f"No pairs in '{show(source)}'; expected {LAYOUT}, or folders of photos and of touches,"
        f" named with --vis and --tac{perhaps}."
    )
    if skipped:
        message += f" {len(skipped)} skipped, such as '{skipped[0].what}': {skipped[0].why}."
    return message
