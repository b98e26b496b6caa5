"""Touch-and-Go (TAG): GelSight and camera frames of one clip, paired by their number.

<root>/dataset/<clip>/{video_frame,gelsight_frame}/<number>.jpg
<root>/{train,test}.txt   the official lists, or label.txt alone: <clip>/<number>.jpg,<label>
<root>/category_reference.txt   name: label
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from omnivat.data.materials import class_key, ruled, rules
from omnivat.data.pairs import Pair, PairSet, Tally
from omnivat.data.readers.files import folders_in, frames_in, is_file, read_lines, show
from omnivat.data.splits import balance, split_by_object
from omnivat.kit.errors import DataError

DOMAIN = "TAG"
VIS, TAC = "video_frame", "gelsight_frame"  # folders in a clip
INCONCLUSIVE = "-1"
TEST_SHARE = 29_879 / (91_982 + 29_879)  # of the official lists, kept when splitting by clip


@dataclass(frozen=True, slots=True)
class Frame:
    """One line of a list."""

    clip: str
    number: int
    label: str  # of the list, then the class
    split: str


def recognises(source: Path) -> bool:
    """True if a folder has clips with GelSight frames."""
    clips = folders_in(source / "dataset") or folders_in(source)
    return any((clip / "gelsight_frame").is_dir() for clip in clips)


def read(
    source: Path,
    *,
    strict: bool = False,
    seed: int = 0,
    by_folder: bool = False,
    balanced: bool = True,
    keep_labels: bool = False,
    lists: Path | str | None = None,
) -> PairSet:
    """Return the pairs of Touch-and-Go.

    source       the folder with `dataset`, or with the clips
    strict       no effect here: metal and tile are its only words for steel and ceramic
    seed         of the balancing and of the split by clip
    by_folder    put whole clips into train or test. The official lists share 100 of their 106
                 test clips with training, so their test pairs are near copies of training pairs
    balanced     draw as many pairs of each class as the smallest has, as the paper seems to
    keep_labels  keep materials beyond the five under their own names
    lists        the folder with train.txt and test.txt, if it is another one

    Without the official lists, label.txt is read and split by clip. Without any list, keep_labels
    uses the clip's name as the class. Raises DataError if there are no pairs.
    """
    left_out = Tally()
    clips = source / "dataset" if (source / "dataset").is_dir() else source
    places = (*((Path(lists),) if lists else ()), source, clips)
    names = _label_names(places)
    files, official = _list_files(places, by_folder)
    if files:
        frames = _materials(list(_listed(files, left_out)), names, strict, keep_labels, left_out)
    elif keep_labels:
        frames = _unlisted(clips)
    else:
        raise DataError(
            f"No labels for the clips in '{show(source)}': neither train.txt and test.txt nor"
            " label.txt is there. Copy them beside the clips, or take the clips' own names as"
            " classes: `omnivat embed` with --set keep_labels=true."
        )
    pairs = tuple(_pairs(frames, clips, left_out))
    if files and not official:
        pairs = split_by_object(pairs, seed=seed, test=TEST_SHARE)
    if balanced and not keep_labels:
        pairs = balance(pairs, left_out, seed=seed)
    how = "official lists" if official else "split by clip" if files else "no lists, no split"
    return left_out.result("Touch-and-Go", source, pairs, how)


def _list_files(places: tuple[Path, ...], by_folder: bool) -> tuple[dict[str, Path], bool]:
    """Return the lists by split, and True for the official split."""
    for place in places:
        both = {split: place / f"{split}.txt" for split in ("train", "test")}
        if all(map(is_file, both.values())):
            return both, not by_folder
        if is_file(place / "label.txt"):
            return {"": place / "label.txt"}, False
    return {}, False


def _listed(files: dict[str, Path], left_out: Tally) -> Iterator[Frame]:
    """Yield the frames of the lists, each once, without inconclusive ones."""
    seen: dict[tuple[str, int], str] = {}
    for split, file in files.items():
        for line in filter(None, read_lines(file)):
            path, _, label = line.rpartition(",")
            clip, _, name = path.strip().partition("/")
            number, label = Path(name).stem, label.strip()
            plain = clip not in ("", ".", "..") and not set(clip) & {"\\", "\0"}
            if not (plain and number.isascii() and number.isdigit() and label):
                left_out.add(show(file.name), "lines that are not <clip>/<number>.jpg,<label>")
            elif label == INCONCLUSIVE:
                left_out.add(show(file.name), "label -1, inconclusive")
            elif earlier := seen.get((clip, int(number))):
                left_out.add(
                    show(clip), "listed twice" if earlier == label else "listed with two labels"
                )
            else:
                seen[clip, int(number)] = label
                yield Frame(clip, int(number), label, split)


def _label_names(places: tuple[Path, ...]) -> dict[str, str]:
    """Return the labels' names in category_reference.txt, checked against our five.

    Raises DataError if one of the five has another name there.
    """
    file = next(
        (p / "category_reference.txt" for p in places if is_file(p / "category_reference.txt")),
        None,
    )
    names: dict[str, str] = {}
    for line in read_lines(file) if file else ():
        name, _, number = line.rpartition(":")
        if name.strip() and number.split():
            names[number.split()[0]] = class_key(name)
    for label, rule in rules("touch_and_go").items():
        if file and label in names and rule.named not in names[label]:
            raise DataError(
                f"'{show(file)}' calls label {label} '{show(names[label])}', expected"
                f" '{rule.named}'. This is another numbering; correct the lists or the file."
            )
    return names


def _materials(
    frames: list[Frame], names: dict[str, str], strict: bool, keep: bool, left_out: Tally
) -> list[Frame]:
    """Return the frames with their classes as labels."""
    known = rules("touch_and_go")
    kept = []
    for frame in frames:
        rule = known.get(frame.label)
        name = rule.named if rule else names.get(frame.label, "")
        material, why = ruled(rule, "labels of other materials", strict=strict)
        if not material and keep:
            material = name or f"label {frame.label}"
        if material:
            kept.append(replace(frame, label=material))
        else:
            left_out.add(f"label {frame.label}" + (f" ({name})" if name else ""), why)
    return kept


def _unlisted(clips: Path) -> list[Frame]:
    """Return every frame of every clip, with the clip's name as the class."""
    return [
        Frame(clip.name, number, class_key(clip.name), "")
        for clip in folders_in(clips)
        for number in sorted(frames_in(clip / TAC).keys() | frames_in(clip / VIS).keys())
    ]


def _pairs(frames: list[Frame], clips: Path, left_out: Tally) -> Iterator[Pair]:
    listed = cache(frames_in)
    for frame in frames:
        folder = clips / frame.clip
        vis, tac = (listed(folder / half).get(frame.number) for half in (VIS, TAC))
        if vis and tac:
            yield Pair(
                vis=vis,
                tac=tac,
                domain=DOMAIN,
                material=frame.label,
                object=frame.clip,
                split=frame.split,
            )
        else:
            missing = [n for n, half in ((VIS, vis), (TAC, tac)) if not half]
            left_out.add(show(frame.clip), f"no image in {' and '.join(missing)}")
