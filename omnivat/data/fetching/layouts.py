"""How the pairs of each set lie in its repository: file names to pairs, labels as the authors
gave them.
"""

import re
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from omnivat.data.materials import NO_CLASS, class_key, rules, rules_in_text
from omnivat.kit.errors import DataError

EACH = 30  # pairs of one object of VT60; presses of one class, sensor and split of sets of presses
MINIS = (0, 4, 5, 6)  # of the sensors of SITR: its code compares these, and 0 with the three others
Box = tuple[float, float, float, float]  # left, top, right, bottom, as shares of the sides
STILL_PHOTO, STILL_TOUCH = (0.597, 0.145, 0.98, 0.855), (0.01, 0.02, 0.53, 0.965)
# of the samples of ObjectFolder Real: copies of 101 to 103, which shift the numbers after them
REPEATS = (71, 82, 99)


@dataclass(frozen=True, slots=True, kw_only=True)
class Item:
    """A pair in a repository. Where there is only a touch, `vis` is "" and it stands for both."""

    vis: str
    tac: str
    domain: str
    material: str
    object: str  # object, swatch or recording, which no split divides
    named: str = ""  # the authors' word, where `material` is another
    boxes: tuple[Box, Box] | None = None  # of photo and touch, where one file holds both
    split: str = ""
    rest: str = ""  # picture of the sensor without contact


T = TypeVar("T")
Names = Sequence[str]
Text = Callable[[str], str]
Layout = Callable[[Names, Text], Iterator[Item]]


def _matches(names: Names, pattern: str) -> Iterator[tuple[str, re.Match[str]]]:
    for name in names:
        if match := re.fullmatch(pattern, name):
            yield name, match


def vt60(names: Names, text: Text) -> Iterator[Item]:
    """Yield 30 pairs of each object: photos and touches evenly spaced by number, in that order."""
    photos: dict[tuple[str, str], list[tuple[int, str]]] = defaultdict(list)
    touches: dict[tuple[str, str], list[tuple[int, str]]] = defaultdict(list)
    for half, there in (("vision", photos), ("touch", touches)):
        for name, match in _matches(names, rf".*/{half}/\d+_(\w+)/(\d+)/\w+_img_(\d+)_.*\.jpg"):
            kind, number, picture = match.groups()
            there[kind, number].append((int(picture), name))
    for kind, number in sorted(photos.keys() & touches.keys()):
        halves = [sorted(there[kind, number]) for there in (photos, touches)]
        for k in range(min(EACH, *map(len, halves))):
            vis, tac = (half[k * len(half) // EACH][1] for half in halves)
            yield Item(vis=vis, tac=tac, domain="VT60", material=kind, object=f"{kind} {number}")


def objectfolder_real(names: Names, text: Text) -> Iterator[Item]:
    """Yield one pair of each object whose material stands in the table of the download page.

    Three samples are copies (REPEATS), so a sample's number is up to 3 above its object's in the
    table. The site names the samples up to 70; above, photos agree with this rule: 84 is the glass
    can, 100 the frisbee.
    """
    table: dict[str, tuple[str, str]] = {}
    page = next((name for name in names if name.endswith(".md")), "")
    if not page:
        raise DataError("The repository has no page (.md) with the table of materials.")
    for line in text(page).splitlines():
        cells = [cell.strip() for cell in line.split("|")[1:-1] if cell]
        table |= {n: (thing, word) for n, thing, word in zip(*[iter(cells)] * 3, strict=False)}
    for tac, match in _matches(names, r"(.*/samples/(\d+)/)tactile/0\.png"):
        folder, number = match.groups()
        index = int(number) - sum(int(number) > n for n in REPEATS)
        thing, word = table.get(str(index), ("", ""))
        rule = rules("objectfolder").get(word.lower())
        if rule and int(number) not in REPEATS and f"{folder}visual/0.png" in names:
            yield Item(
                vis=f"{folder}visual/0.png",
                tac=tac,
                domain="OF Real",
                material=rule.material,
                object=f"{index} {thing}",
                named=word,
            )


def hapticmatch(names: Names, text: Text) -> Iterator[Item]:
    """Yield the spots of each swatch. Its class is its name, or the material that the name
    contains.
    """
    for tac, match in _matches(names, r"(Texture/(\w+?)(\d*)/\d+)\.pkl"):
        stem, kind, number = match.groups()
        words = class_key(" ".join(re.findall(r"[A-Z]?[a-z]+|[A-Z]+", kind)))
        found = [
            rule for rule in rules_in_text(words, "tacquad") if rule.material and not rule.merged
        ]
        if f"{stem}.jpg" in names:
            yield Item(
                vis=f"{stem}.jpg",
                tac=tac,
                domain="HapticMatch",
                material=found[0].material if len(found) == 1 else words,
                object=kind + number,
                named=words,
            )


def files(
    domain: str,
    tac: str,
    *,
    vis: str = "",
    material: str = r"\1",
    thing: str = r"\1 \2",
    named: str = "",
    boxes: tuple[Box, Box] | None = None,
) -> Layout:
    """Return the layout of touches whose names match `tac`; the other texts are templates of its
    groups. A touch whose photo is not there is left out.
    """

    def items(names: Names, text: Text) -> Iterator[Item]:
        for name, match in _matches(names, tac):
            photo = match.expand(vis)
            kind, whole = (
                match.expand(template).replace("_", " ") for template in (material, thing)
            )
            if not photo or photo in names:
                yield Item(
                    vis=photo,
                    tac=name,
                    domain=domain,
                    material=kind,
                    object=whole,
                    named=named,
                    boxes=boxes,
                )

    return items


def billets(names: Names, text: Text) -> Iterator[Item]:
    """Yield the places of each billet, with the two states of its surface as classes."""
    for state, photos, end in (("ground", "", "_grinded"), ("unground", "non ", "")):
        layout = files(
            "Billets",
            rf"billet_captures{end}/(billet\d+)_(camera_\d+)\.png",
            vis=rf"camera_images/{photos}grinded/\1_\2.jpg",
            material=state,
            thing=rf"{state} \1",
            named="metal",
        )
        yield from layout(names, text)


def spaced(items: Iterable[T], key: Callable[[T], Hashable]) -> Iterator[T]:
    """Yield at most EACH items of every key, evenly spaced in their order."""
    groups: dict[Hashable, list[T]] = defaultdict(list)
    for item in items:
        groups[key(item)].append(item)
    for group in groups.values():
        count = min(EACH, len(group))
        yield from (group[k * len(group) // count] for k in range(count))


def sitr(names: Names, text: Text) -> Iterator[Item]:
    """Yield presses of each class, sensor and split; a class is one object, a press has no other
    name.
    """
    pattern = r"(.*?(train|val)_set/sensor_(\d+)/)samples/class_(\d+)/(\d+)\.png"
    there = frozenset(names)

    def items() -> Iterator[Item]:
        for tac, match in _matches(sorted(names), pattern):
            folder, split, sensor, kind, number = match.groups()
            rest = f"{folder}calibration/0000.png"
            yield Item(
                vis="",
                tac=tac,
                domain=f"SITR {int(sensor)}" + " (GelSight Mini)" * (int(sensor) in MINIS),
                material=f"object {int(kind)}",
                object=f"{int(sensor)} {split} {int(kind)} {number}",
                split=split,
                rest=rest if rest in there else "",
            )

    return spaced(items(), lambda item: (item.domain, item.split, item.material))


def probes(names: Names, text: Text) -> Iterator[Item]:
    """Yield presses of each pad of the GelSight Mini and each folder below it, an indenter or an
    object; `initial` is the pad without contact.
    """
    pattern = r"(.*gelsight_mini/mini_(pad\d+)(?:_ob)?/(?:([^/]+)/)?)(?:.*/)?([^/]+)\.(?:jpe?g|png)"
    there = frozenset(names)

    def items() -> Iterator[Item]:
        for tac, match in _matches(sorted(names), pattern):
            folder, pad, kind, stem = match.groups()
            rests = [f"{folder}initial{end}" for end in (".jpg", ".png")]
            if stem != "initial":
                yield Item(
                    vis="",
                    tac=tac,
                    domain=f"GelSight Mini, {pad}",
                    material=class_key(kind or "") or NO_CLASS,
                    object=f"{pad} {kind or ''} {stem}",
                    rest=next((rest for rest in rests if rest in there), ""),
                )

    return spaced(items(), lambda item: (item.domain, item.material))


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows:
    """How the rows of a set's Parquet files are named: its columns by ours ("": none), and the
    domain of a file's rows by its name.
    """

    columns: Mapping[str, str]
    domain: Callable[[str], str]


def _feats(name: str) -> str:
    """Return the sensor of a file of FEATS; two of its test sets are of another GelSight Mini."""
    other = re.search(r"diff_sensor_(new|old)_gel", name)
    return f"GelSight Mini, other, {other[1]} gel" if other else "GelSight Mini"


ROWS = {
    "feats-mini": Rows(
        columns={"material": "indenter", "object": "indenter_param", "domain": "", "split": ""},
        domain=_feats,
    )
}
LAYOUTS: dict[str, Layout] = {
    "vt60": vt60,
    "objectfolder-real": objectfolder_real,
    "billets": billets,
    # the frames of each recording; its class is its folder's name without a number
    "tag-samples": files(
        "Touch and Go",
        r"data/(([a-z]+)\d*)/gelsight_frame/touch_image_(\d+)\.png",
        vis=r"data/\1/video_frame/rgb_image_\3.png",
        material=r"\2",
        thing=r"\1",
    ),
    # the stills of the page: a framed touch on the left, a framed photo on the right
    "touch-and-go": files(
        "Touch and Go",
        r".*/([a-z]+)_eg\.png",
        vis=r"\g<0>",
        thing=r"\1",
        boxes=(STILL_PHOTO, STILL_TOUCH),
    ),
    "hapticmatch": hapticmatch,
    # touches alone: the part of an object is the class, a file the object
    "sitr": sitr,
    "glowtact-mini": probes,
    "octopi": files("Octopi", r"dataset/(\w+)_(\d+)\.mov"),
    "digit-parts": files("DIGIT", r"data/(\w+)/interaction_(\d+)\.jpg"),
}
