"""ObjectFolder 2.0, benchmark release: objects 1 to 100 are OF 2.0 A, 101 to 1000 OF 2.0 B.

<root>/vision/<object>/<instance>.png    <root>/touch/<object>/<instance>.png
<root>/label.json    {object: label}, a number for each material
<root>/split.json    {train|val|test: [[object, instance], ...]}
<root>/objects.csv   id,name,scale,Material,url without a header: from the project's repository
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from random import Random

from omnivat.data.materials import class_key, ruled, rules
from omnivat.data.pairs import Pair, PairSet, Tally
from omnivat.data.readers.files import (
    folders_in,
    frames_in,
    is_file,
    number_of,
    numbered_rows,
    show,
)
from omnivat.kit.errors import DataError
from omnivat.kit.schema import read_object
from omnivat.kit.seeding import derive_seed
from omnivat.kit.tables import require_choice

A, B = "OF 2.0 A", "OF 2.0 B"
LAST_OF_A = 100
TOUCH_CROP = 320  # pixels; the release's loader crops touch to this before resizing
TEST_OBJECTS = 5  # of each class, in A and in B: the paper's 500 test pairs a class
SPLITS = ("paper", "release")


def recognises(source: Path) -> bool:
    """True if a folder has the layout of the ObjectFolder benchmark's release."""
    return is_file(source / "label.json") and (source / "touch").is_dir()


def read(source: Path, *, strict: bool = False, seed: int = 0, split: str = "paper") -> PairSet:
    """Return the pairs of ObjectFolder 2.0, A and B.

    source   the release's folder, with `vision` and `touch`
    strict   leave out iron (as steel) and polycarbonate (as plastic)
    seed     of the draw of objects
    split    "paper" draws equally many objects of each class, five for testing, which gives the
             paper's counts; "release" uses all pairs and splits of split.json

    label.json does not name its numbers, so they are matched with objects.csv. Raises DataError if
    one number has two materials, if a file is missing, or if there are no pairs.
    """
    require_choice("split", split, SPLITS)
    left_out = Tally()
    raw = materials_of_objects(source)
    things = _things(source, raw, strict, left_out)
    pairs = [pair for thing in things for pair in _pairs(source, thing, things[thing], left_out)]
    if split == "release":
        pairs, how = _released(source, pairs, left_out), "split.json"
    else:
        pairs, how = _drawn(pairs, seed, left_out), "objects drawn as many a class"
    return left_out.result("ObjectFolder 2.0", source, pairs, how, simulated=True)


def materials_of_objects(source: Path) -> dict[int, str]:
    """Return each labelled object's material, after checking it against label.json.

    Raises DataError unless every number of label.json matches one material and every material one
    number.
    """
    file, table = source / "label.json", source / "objects.csv"
    listed = read_object(file).items()
    try:
        labels = {int(thing): int(label) for thing, label in listed}
    except (TypeError, ValueError) as error:
        raise DataError(f"'{show(file)}' holds something else than numbers: {error}.") from error
    materials = _materials(table)
    first: dict[int | str, tuple[int, str]] = {}  # label, and material -> both, where first seen
    for thing in labels.keys() & materials.keys():
        both = labels[thing], materials[thing]
        for known in both:
            label, name = first.setdefault(known, both)
            if (label, name) != both:
                raise DataError(
                    f"label.json gives {name} the label {label} and {both[1]} the label {both[0]}"
                    f" (object {thing} in '{show(table)}'). The two files do not belong together."
                )
    return {thing: materials.get(thing, "") for thing in labels}


def _materials(table: Path) -> dict[int, str]:
    if not is_file(table):
        raise DataError(
            f"No table of objects at '{show(table)}'. The release does not name the materials: "
            "copy objects.csv of the ObjectFolder repository there."
        )
    rows = numbered_rows(table).values()
    return {int(row[0]): class_key(row[3]) for row in rows if len(row) > 3 and row[0].isdecimal()}


def _things(source: Path, raw: dict[int, str], strict: bool, left_out: Tally) -> dict[int, str]:
    """Return the objects to keep, with their materials."""
    known = rules("objectfolder")
    things = {}
    for thing, name in sorted(raw.items()):
        material, why = ruled(known.get(name), name, strict=strict)
        if material:
            things[thing] = material
        else:
            left_out.add("objects", why if name else "objects.csv does not name its material")
    for folder in folders_in(source / "touch"):
        if not folder.name.isdecimal() or int(folder.name) not in raw:
            left_out.add(f"touch/{show(folder.name)}", "label.json does not name it")
    return things


def _pairs(source: Path, thing: int, material: str, left_out: Tally) -> Iterator[Pair]:
    vis = frames_in(source / "vision" / str(thing))
    tac = frames_in(source / "touch" / str(thing))
    for half, other, missing in ((vis, tac, "touch"), (tac, vis, "vision")):
        if lone := len(half.keys() - other.keys()):
            left_out.add(f"object {thing}", f"no image in {missing}", lone)
    for instance in sorted(vis.keys() & tac.keys()):
        yield Pair(
            vis=vis[instance],
            tac=tac[instance],
            domain=A if thing <= LAST_OF_A else B,
            material=material,
            object=str(thing),
            tac_crop=TOUCH_CROP,
        )


def _released(source: Path, pairs: list[Pair], left_out: Tally) -> list[Pair]:
    """Return the pairs that split.json lists, with its splits."""
    file = source / "split.json"
    listed = read_object(file).items()
    try:
        where = {
            (str(int(thing)), int(k)): name for name, members in listed for thing, k in members
        }
    except (TypeError, ValueError) as error:
        raise DataError(
            f"'{show(file)}' is no split ({error}); expected [object, instance] under train, val,"
            " test."
        ) from error
    placed = [(pair, where.get((pair.object, number_of(pair.tac) or 0))) for pair in pairs]
    if lost := sum(name is None for _, name in placed):
        left_out.add("instances", "split.json does not list them", lost)
    return [replace(pair, split=name) for pair, name in placed if name]


def _drawn(pairs: list[Pair], seed: int, left_out: Tally) -> list[Pair]:
    """Return equally many objects of each class, split to match the paper's counts.

    B: as many objects of each class as the rarest has, five of them for testing. A: as many as the
    rarest has for training, up to five others for testing. A class without others is tested on its
    training objects, which is harmless because A is never tested on itself.
    """
    things: dict[tuple[str, str], dict[str, list[Pair]]] = defaultdict(lambda: defaultdict(list))
    for pair in pairs:
        things[pair.domain, pair.material][pair.object].append(pair)
    rarest = {
        d: min(len(members) for (name, _), members in things.items() if name == d)
        for d, _ in things
    }
    drawn: list[Pair] = []
    for (domain, material), members in things.items():
        order = list(members)
        Random(derive_seed(seed, "objects", domain, material)).shuffle(order)
        count = rarest[domain]
        if domain == A:
            train = order[:count]
            test = order[count : count + TEST_OBJECTS] or train
        else:
            cut = count - min(TEST_OBJECTS, count // 2)
            train, test = order[:cut], order[cut:count]
        for name, chosen in (("train", train), ("test", test)):
            drawn += [replace(pair, split=name) for thing in chosen for pair in members[thing]]
    used = {(pair.domain, pair.object) for pair in drawn}
    if lost := sum((pair.domain, pair.object) not in used for pair in pairs):
        left_out.add("pairs of other objects", "as many objects a class", lost)
    return drawn
