"""What names tell: formats of picture files, photo or touch, splits, and which names are equal.

The rules of every reader, of recordings and of foreign files; documents and the page follow them.
"""

import os
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

from omnivat.kit.errors import DataError, printable
from omnivat.kit.stages import IMAGES
from omnivat.kit.tables import suggestion

COMMON = {  # formats that visitors of the page may send -> suffixes of their files
    "PNG": "png apng",
    "JPEG": "jpg jpeg jpe jfif",
    "WEBP": "webp",
    "GIF": "gif",
    "BMP": "bmp",
    "TIFF": "tif tiff",
}
FORMATS = COMMON | {
    "PPM": "ppm pgm pnm",
    "QOI": "qoi",
    "JPEG2000": "jp2 j2k",
    "HEIF": "heic heif",
    "AVIF": "avif",
    "DIB": "dib",
    "TGA": "tga",  # last: nothing in its content tells this format
}
SUFFIXES = {f".{suffix}": kind for kind, all in FORMATS.items() for suffix in all.split()}
VIDEOS = (".mp4", ".mov", ".avi", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg")
TACTILE = (".hapt", ".touch")  # recordings of tactile packages
HALVES = {
    "vis": "vis vision visual photo photos rgb color colour",
    "tac": "tac tact tacto tactile touch touches gelsight gelslim digit duragel dtact tactip",
    "?": "gel gels finger fingers fingertip fingertips elastomer",  # a touch, or a camera there
}
COLUMNS = {  # of tables and files of vectors -> other names of theirs
    "material": ("class", "label", "labels", "class_name", "category", "material_name"),
    "domain": ("sensor", "sensor_type", "sensor_name"),
    "object": (
        *("item", "object_id", "object_name", "item_id"),
        *("specimen", "specimen_id", "instance", "instance_id"),
    ),
}
SPLIT_COLUMNS = ("set", "subset", "partition")  # of tables, where each cell names a split
SPLITS = {
    "train": "train training trainset",
    "val": "val valid validation dev valset",
    "test": "test testing testset",
}
NO_PHOTO = {"depth", "mask", "masks", "seg", "segmentation", "disparity"}  # beside other cameras
NEUTRAL = "data dataset set split image images img imgs picture pictures"  # beside a split's word


def _by_word(table: Mapping[str, str]) -> dict[str, str]:
    return {word: name for name, words in table.items() for word in words.split()}


_HALF_OF, _SPLIT_OF = _by_word(HALVES), _by_word(SPLITS)
_NEUTRAL = frozenset(NEUTRAL.split())


def is_image_name(name: str) -> bool:
    """True if a file's suffix, in any case, is that of a picture."""
    return os.path.splitext(name)[1].lower() in SUFFIXES


def is_file_name(name: str) -> bool:
    """True if a file's suffix, in any case, is that of a picture or a recording."""
    return is_image_name(name) or name.lower().endswith((*VIDEOS, *TACTILE))


def half_of(name: str) -> str:
    """Return "vis" or "tac" by the whole words of a name, "?" if they leave it open, or "".

    >>> [half_of(name) for name in ("observation.tactile.left", "GelSight2", "wrist_rgb")]
    ['tac', 'tac', 'vis']
    >>> [half_of(name) for name in ("contact_cam", "angel_top", "finger_left")]
    ['', '', '?']
    """
    found = set()
    for text in re.findall(r"[^\W\d_]+", name):
        parts = re.findall(r"[A-Z]?[^A-Z]+|[A-Z]+(?![^A-Z])", text)
        words = [text, *parts, *map("".join, pairwise(parts))]  # Gel, Sight
        found |= {_HALF_OF.get(word.lower(), "") for word in words}
    return next((half for half in ("tac", "vis", "?") if half in found), "")


def halves_among(names: Iterable[str]) -> dict[str, list[str]]:
    """Return the names by `half_of`, those without a word under "".

    >>> halves_among(["wrist", "tactile_left", "tactile_right"])
    {'vis': [], 'tac': ['tactile_left', 'tactile_right'], '?': [], '': ['wrist']}
    """
    found: dict[str, list[str]] = {half: [] for half in (*HALVES, "")}
    for name in names:
        found[half_of(name)].append(name)
    return found


def cameras_among(
    names: Sequence[str], vis: str, tac: Sequence[str], where: str
) -> tuple[str, list[str], list[str]]:
    """Return the camera of photos, those of touches, and what tells several of these apart.

    names     of cameras, or of columns of pictures
    vis, tac  those named by a person; "" and (): by whole words, and a single one left is the photo
    where     "'NAME'", for errors
    return    photo ("" without one), touches ([""] without one), a text for each touch

    Raises DataError for an unknown name, and where a choice would be a guess.

    >>> cameras_among(["wrist", "left.tactile", "right.tactile"], "", (), "'press'")
    ('wrist', ['left.tactile', 'right.tactile'], ['left.tactile', 'right.tactile'])
    """
    there = printable(", ".join(names) or "none")
    for name in filter(None, (vis, *tac)):
        if name not in names:
            raise DataError(f"{where} has no camera '{printable(name)}'; it has {there}.")
    halves = halves_among(names)
    touches = list(tac) or halves["tac"]
    if not touches and not vis:
        raise DataError(
            f"No camera of {where} is called tactile; name one with --tac, or the photos alone with"
            f" --vis. There are {there}."
        )
    others = [name for name in names if name not in touches]
    seen = [name for name in others if not NO_PHOTO & {*re.split(r"[\W_\d]+", name.lower())}]
    others = others if vis or not seen else seen
    visual = [name for name in halves["vis"] if name in others]
    photos = [vis] if vis else visual if len(visual) == 1 else others
    if len(photos) > 1 or (not vis and photos and photos[0] in halves["?"]):
        raise DataError(
            f"The touch of {where} is {printable(' and '.join(touches))}. Name the camera of photos"
            f" with --vis: {printable(', '.join(others))}."
        )
    if len(touches) < 2:
        return "".join(photos), touches or [""], [""]
    endings = [name.rpartition(".")[2] for name in touches]  # left.tac and right.tac end alike
    return "".join(photos), touches, endings if len({*endings}) == len(touches) else touches


def modality_of(path: Path) -> str:
    """Return "vis" or "tac" by the last word of a file's stem, else by its first one, or else by
    its folder's name; "" for neither.

    >>> modality_of(Path("1_tac.png")), modality_of(Path("rgb 1.png")), modality_of(Path("tac/1"))
    ('tac', 'vis', 'tac')
    """
    folder = path.parent.name.lower()
    return _told(composed(path.stem))[0] or (folder if folder in IMAGES else "")


def without_half(stem: str) -> str:
    """Return a file's stem without the word that tells its modality.

    >>> without_half("press_01_GelSight"), without_half("rgb_7"), without_half("tac")
    ('press_01', '7', '')
    """
    return _told(composed(stem))[1]


def half_at_end(stem: str) -> tuple[str, str]:
    """Return the modality that the last word of a stem tells, "" for none, and the rest."""
    end = re.search(r"(?:^|[\W_]+)([^\W\d_]+)$", stem)
    half = half_of(end[1]) if end else ""
    return (half, stem[: end.start()]) if end and half in IMAGES else ("", stem)


def _told(stem: str) -> tuple[str, str]:
    half, rest = half_at_end(stem)
    first = re.match(r"([^\W\d_]+)[\W_]+(?=.)", stem)
    if not half and first and half_of(first[1]) in IMAGES:
        return half_of(first[1]), stem[first.end() :]
    return half, rest


def split_of(name: str) -> str:
    """Return "train", "val" or "test" for a name of one, or "".

    >>> split_of("Validation"), split_of("1_train_images"), split_of("test bench")
    ('val', 'train', '')
    """
    words = re.sub(r"^\d+[\s_-]+", "", name.strip().casefold())
    found = {_SPLIT_OF.get(w, "") for w in re.split(r"[\s_-]+", words) if w not in _NEUTRAL}
    return "".join(found) if len(found) == 1 else ""


def splits_within(names: Iterable[str]) -> dict[str, tuple[str, str]]:
    """Return name -> the rest of it and its split, of names that begin or end with a split's word,
    where one rest has two splits.

    >>> splits_within(["wood_train", "wood_test", "glass"])
    {'wood_train': ('wood', 'train'), 'wood_test': ('wood', 'test')}
    >>> splits_within(["test bench", "train seat"])
    {}
    """
    found = {}
    for name in names:
        for pattern in (
            r"(?P<word>[^\W_]+)[\s_-]+(?P<rest>.+)",
            r"(?P<rest>.+?)[\s_-]+(?P<word>[^\W_]+)",
        ):
            match = re.fullmatch(pattern, name.strip())
            if match and (split := _SPLIT_OF.get(match["word"].casefold())):
                found[name] = match["rest"], split
    keys = {(rest.casefold(), split) for rest, split in found.values()}
    return found if len({rest for rest, _ in keys}) < len(keys) else {}


def checked_split(name: str, what: str) -> str:
    """Return the split of a name, "" of none; raises DataError with `what` for another name."""
    if name and not split_of(name):
        raise DataError(
            f"{what}: there is no split '{printable(name[:60])}'; expected {', '.join(SPLITS)} or"
            f" nothing.{suggestion(name.casefold(), SPLITS)}"
        )
    return split_of(name)


def set_name(folder: Path) -> str:
    """Return the name of the nearest folder, from `folder` up, that is not a split's."""
    above = (place.name for place in (folder, *folder.parents))
    return next((composed(name) for name in above if name and not split_of(name)), "pictures")


def composed(name: str) -> str:
    """Return a name with composed letters: macOS writes "é" as two characters."""
    return unicodedata.normalize("NFC", name)


def one_spelling(names: Iterable[str]) -> list[str]:
    """Return names in their first spelling: another case or blanks make no other object.

    >>> one_spelling(["Mug 1", "mug  1 ", "fork"])
    ['Mug 1', 'Mug 1', 'fork']
    """
    first: dict[str, str] = {}
    return [first.setdefault(" ".join(_same(name).split()), name) for name in names]


def found_file(folder: Path, name: str) -> Path:
    """Return the file that a table names from `folder`; backslashes, other Unicode forms, letters
    of another case and a suffix left out are no obstacle where one file fits. Of a path that is
    absolute on another machine, its end counts. The plain path if nothing fits.
    """
    plain = folder / name
    if os.path.exists(plain):
        return plain
    parts = Path(name.replace("\\", "/")).parts
    foreign = os.path.isabs(name) or re.match(r"[A-Za-z]:$|//|/$", parts[0] if parts else "")
    for first in range(1, len(parts)) if foreign else (0,):
        if found := _fitting(folder, parts[first:]):
            return found
    return plain


def _fitting(folder: Path, parts: Sequence[str]) -> Path | None:
    path = folder
    for part in parts:
        if not os.path.exists(path / part):
            listed = _listed(path)
            near = listed.get(_same(part), ()) or [
                name
                for names in listed.values()
                for name in names
                if is_file_name(name) and _same(os.path.splitext(name)[0]) == _same(part)
            ]
            exact = [other for other in near if composed(other) == composed(part)] or near
            if len(exact) != 1:
                return None
            part = exact[0]
        path = path / part
    return path


def _same(name: str) -> str:
    return composed(name).casefold()


def _listed(folder: Path) -> dict[str, list[str]]:
    try:
        return _by_same_name(folder, folder.stat().st_mtime_ns)
    except (OSError, ValueError):
        return {}


@lru_cache(maxsize=16)  # a table names many files of one folder
def _by_same_name(folder: Path, changed: int) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for name in os.listdir(folder):
        found.setdefault(_same(name), []).append(name)
    return found
