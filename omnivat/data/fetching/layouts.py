"""How the pairs of each set lie in its repository: file names to pairs, labels as the authors
gave them.
"""

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from omnivat.data.materials import class_key, rules, rules_in_text
from omnivat.kit.errors import DataError

EACH = 30  # pairs of one object of VT60
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
            kind, whole = (match.expand(one).replace("_", " ") for one in (material, thing))
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
    "octopi": files("Octopi", r"dataset/(\w+)_(\d+)\.mov"),
    "digit-parts": files("DIGIT", r"data/(\w+)/interaction_(\d+)\.jpg"),
}
