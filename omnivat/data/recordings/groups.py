"""What the names of groups, folders and files tell about the pictures in them: which are cameras,
which recordings or single pictures, which splits.

A picture's place is the names above it and its own, such as data, demo_0, obs, wrist_image.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from omnivat.data.naming import half_at_end, half_of, split_of
from omnivat.kit.stages import IMAGES

# words of groups that hold the cameras of one recording
FRAMES = {"obs", "observation", "observations", "images", "image", "imgs", "pictures", "frames"}
FRAMES |= {"cameras", "camera", "sensors"}
SHOTS = FRAMES | {"img", "pic", "picture", "frame"}  # of single pictures
# of cameras, which tell neither photo nor touch
CAMERAS = SHOTS | {
    "cam",
    "view",
    "sensor",
    "left",
    "right",
    "front",
    "back",
    "top",
    "side",
    "depth",
}
CAMERAS |= {"wrist", "hand", "arm", "overhead", "head", "eye", "scene", "robot", "gripper"}
CAMERAS |= {"agentview", "workspace", "external", "exterior", "interior"}
EVENTS = {"touch", "touches", "contact", "press"}  # touch_0 is a recording, digit_0 a camera
MOST_CAMERAS = 4  # of one wording with numbers; more are recordings
BETWEEN = "_- ."  # words of a name
AFTER = "next_obs"  # robomimic: the pictures of obs, a step later
ENDS_IN_NUMBER = re.compile(r"(.*?)[\W_]*\d+")


@dataclass(slots=True)
class Place:
    """One column of pictures, and what its names tell.

    names    above it and its own
    still    it is a single picture
    units    names of its recording: of groups, files and folders that stand beside others
    counted  which of these end in a number
    camera   the names that tell its camera, with slashes; "" of none
    shot     name of a single picture among others
    """

    names: tuple[str, ...]
    still: bool
    units: tuple[str, ...] = ()
    counted: tuple[bool, ...] = ()
    camera: str = ""
    split: str = ""
    shot: str = ""

    def met(self, name: str, counted: bool) -> None:
        self.units, self.counted = (*self.units, name), (*self.counted, counted)

    def seen_by(self, name: str) -> None:
        self.camera = "/".join(filter(None, (self.camera, name)))


def tell(places: Sequence[Place], named: Collection[str] = ()) -> None:
    """Fill in what the names of places tell.

    named  names of cameras that a person gave
    """
    groups: dict[Hashable, list[Place]] = {(): [*places]}
    for depth in range(max((len(place.names) for place in places), default=0)):
        deeper: dict[Hashable, list[Place]] = defaultdict(list)
        for prefix, here in groups.items():
            near = _near(here, depth, named)
            for place in here:
                if depth + 1 == len(place.names):
                    _tell_last(place, near, named)
                else:
                    key = _tell_group(place, depth, near, named)
                    deeper[prefix, key].append(place)
        groups = deeper


def _words(name: str) -> set[str]:
    return {*re.split(r"[\W_\d]+", name.casefold())} - {""}


def _kind(name: str, rest: Sequence[str]) -> str:
    """Return what the name of a group is: "camera", "split", "counted" or "" for none of these."""
    number, words = ENDS_IN_NUMBER.fullmatch(name), _words(name)
    below = any(half_of(name) in IMAGES for name in rest)
    if split_of(name):
        return "split"
    if number and (below or words <= EVENTS or not (half_of(name) or words & CAMERAS - FRAMES)):
        return "counted"
    return "camera" if half_of(name) or words & CAMERAS else ""


class _Near(NamedTuple):
    """What the names at one depth of a group tell together.

    groups, columns  names without a meaning of their own, of two or more
    shots            beginnings of single pictures' names that two halves share
    series           beginnings of columns' names with more numbers than there are cameras
    """

    groups: set[str]
    columns: set[str]
    shots: set[str]
    series: set[str]


def _near(here: Sequence[Place], depth: int, named: Collection[str]) -> _Near:
    groups, columns, shots, series = set(), set(), Counter[str](), Counter[str]()
    inside = any(_words(name) & FRAMES for place in here for name in place.names[:depth][-1:])
    for place in here:
        name, rest = place.names[depth], place.names[depth + 1 :]
        if rest:
            groups |= {name} if not _kind(name, rest) else set()
            continue
        if half_of(name) or name in named or (not place.still and _words(name) & CAMERAS):
            inside = True  # beside a camera, others are cameras
        columns.add(name)
        shots[half_at_end(name)[1]] += place.still
        if number := ENDS_IN_NUMBER.fullmatch(name):
            series[number[1]] += not place.still
    return _Near(
        groups if len(groups) > 1 else set(),
        columns if len(columns) > 1 and not inside else set(),
        {shot for shot, count in shots.items() if shot and count > 1},
        {stem for stem, count in series.items() if count > MOST_CAMERAS},
    )


def _tell_group(place: Place, depth: int, near: _Near, named: Collection[str]) -> str:
    """Note what the name of a group tells; return what is alike for groups that may be compared."""
    name, rest = place.names[depth], place.names[depth + 1 :]
    kind = "camera" if name in named else _kind(name, rest)
    if kind == "split":
        place.split = split_of(name)
        return "split"
    if kind == "counted":
        place.met(name, counted=True)
        if half_of(name) in IMAGES and not any(half_of(name) in IMAGES for name in rest):
            place.seen_by(re.sub(r"[\W_]*\d+$", "", name))
        return "unit"
    if kind == "camera":
        place.seen_by(name)
        return f"camera {name}"
    if name in near.groups:
        place.met(name, counted=False)
        return "unit"
    return f"only {name}"


def _tell_last(place: Place, near: _Near, named: Collection[str]) -> None:
    """Note what a column's own name tells."""
    name = place.names[-1]
    (_, shot), number = half_at_end(name), ENDS_IN_NUMBER.fullmatch(name)
    camera = bool(_words(name) & CAMERAS - SHOTS)
    if name in named:
        place.seen_by(name)
    elif place.still and shot != name and (shot in near.shots or re.search(r"\d", shot)):
        place.shot = shot
        place.seen_by(name[len(shot) :].strip(BETWEEN))
    elif place.still and number and not camera:
        place.shot = name[len(number[1]) :].strip(BETWEEN)
        place.seen_by(number[1])
    elif place.still and name in near.columns:
        place.shot = name
    elif number and (number[1] in near.series or _words(name) <= EVENTS) and not place.still:
        half = half_of(name)  # rgb_0 and tac_0 are of one recording
        place.met(name[len(number[1]) :].strip(BETWEEN) if half else name, counted=True)
        place.seen_by(number[1] if half else "")
    elif name in near.columns:
        place.met(name, counted=bool(number))
    else:
        place.seen_by(name)


Units = tuple[str, ...]


def classes_of(
    counted: Mapping[Units, tuple[bool, ...]],
) -> tuple[dict[Units, str], dict[Units, str]]:
    """Return units -> class and units -> domain, as far as the names of groups tell them.

    counted  units -> whether each ends in a number

    One level of names without numbers is the class. Of two, the first is the domain if it is one
    for all, or a second name occurs below several; else it is the class. Where every name ends in
    a number, different words before it, as in mug_1 and fork_1, are classes.
    """
    levels = {
        units: [n for n, c in zip(units, counts, strict=True) if not c]
        for units, counts in counted.items()
    }
    pairs = {tuple(found[:2]) for found in levels.values() if len(found) > 1}
    domains = bool(pairs) and len({b for _, b in pairs}) < len(pairs)
    ends = {u: ENDS_IN_NUMBER.fullmatch(u[-1]) for u in levels if u}
    stems = {units: end[1] for units, end in ends.items() if end}
    if not any(levels.values()):
        return (stems if len({*stems.values()}) > 1 else {}), {}
    at = 1 if domains else 0
    named = {u: found[min(at, len(found) - 1)] for u, found in levels.items() if found}
    return named, {u: found[0] for u, found in levels.items() if domains and len(found) > 1}
