"""TacQuad (TQ): four sensors on the same items, indoors and outdoors.

<root>/contact_{indoor,outdoor}.csv   item, then first and last frame in contact for GelSight
                                      Mini, DIGIT and DuraGel, optionally a caption; no header
<root>/data_{indoor,outdoor}/<item>/{gelsight,digit,duragel}/<number>.png    touch, from 0
<root>/data_{indoor,outdoor}/<item>/img_{gelsight,digit,duragel,tac3d}/<number>.png
<root>/data_indoor/<item>/tac3d/<number>.npy    20 x 20 x 3; missing in some copies
<root>/materials.csv   item,material: overrides names and captions
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random

from omnivat.data.materials import MATERIALS, class_key, ruled, rules_in_text
from omnivat.data.pairs import Pair, PairSet, Tally
from omnivat.data.readers.files import frames_in, is_file, numbered_rows, read_names, show
from omnivat.data.splits import split_by_object
from omnivat.data.tac3d import draw_all
from omnivat.kit.errors import DataError
from omnivat.kit.files import cache_folder
from omnivat.kit.seeding import derive_seed
from omnivat.kit.tables import suggestion

PARTS = ("indoor", "outdoor")
RENAMED = {"yumaoqiu": "shuttlecock", "yumaoqiu2": "shuttlecock2"}  # list -> folder
ARRAYS = frozenset({".npy"})
TRAIN, TEST = 41, 15  # frames of an item: 779 = 19 * 41, 285 = 19 * 15, 525 = 35 * 15
T3D_TEST_SHARE = 682 / (1_196 + 682)  # of the paper's counts


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor's domain, its folder, and the column of its first frame in contact_*.csv."""

    domain: str
    folder: str
    column: int


SENSORS = (
    Sensor("TQ-GelMini", "gelsight", 1),
    Sensor("TQ-DIGIT", "digit", 3),
    Sensor("TQ-DuraGel", "duragel", 5),
)
TAC3D = Sensor("TQ-T3D", "tac3d", -1)


@dataclass(frozen=True, slots=True)
class Contact:
    """One row of contact_*.csv: an item, touched by every sensor."""

    part: str
    item: str
    material: str
    cells: list[str]
    folder: Path

    def by(self, sensor: Sensor) -> str:
        """Return the name of the touches of one sensor, for what is left out."""
        return f"{self.part}/{show(self.item)}, {sensor.domain}"


def recognises(source: Path) -> bool:
    """True if a folder has TacQuad's contact lists."""
    return is_file(source / "contact_indoor.csv") or is_file(source / "contact_outdoor.csv")


def read(
    source: Path,
    *,
    strict: bool = False,
    seed: int = 0,
    all_frames: bool = False,
    by_object: bool = False,
) -> PairSet:
    """Return the pairs of TacQuad, as four domains with an indoor and an outdoor part.

    source      the folder with contact_indoor.csv
    strict      leave out iron and aluminium (as steel)
    seed        of the draw of frames
    all_frames  keep every frame in contact; otherwise 41 training and 15 test frames of each
                outdoor item and 15 test frames of each indoor item, as the paper's counts suggest
    by_object   put whole outdoor items into train or test; otherwise frames of one item are in both

    The images of Tac3D fields lie in the user's cache folder.
    Raises DataError if there are no pairs.
    """
    left_out = Tally()
    contacts = list(_contacts(source, strict, left_out))
    pairs: list[Pair] = []
    for contact in contacts:
        for sensor in SENSORS:
            pairs += _with_splits(
                list(_touches(contact, sensor, left_out)), contact, sensor, seed, all_frames
            )
    pairs += _tac3d(contacts, cache_folder() / "tac3d", seed, left_out)
    if by_object:
        pairs = _by_object(pairs, seed)
    how = "all frames in contact" if all_frames else "frames drawn to the paper's counts"
    return left_out.result("TacQuad", source, pairs, how)


def _contacts(source: Path, strict: bool, left_out: Tally) -> Iterator[Contact]:
    """Yield the rows of both parts whose item exists and has one of the five materials."""
    overrides = _overrides(source / "materials.csv")
    for part in PARTS:
        file = source / f"contact_{part}.csv"
        if not is_file(file):
            left_out.add(f"{part} part", f"no {file.name}")
            continue
        for cells in numbered_rows(file).values():
            item = RENAMED.get(cells[0], cells[0])
            folder = source / f"data_{part}" / item
            material, why = material_of(item, " ".join(cells[7:]), overrides, strict=strict)
            if not item or "/" in item or item in (".", "..") or not folder.is_dir():
                left_out.add(f"{part}/{show(item)}", "listed, but the folder is missing")
            elif why:
                left_out.add(f"{part}/{show(item)}", why)
            else:
                yield Contact(part, item, material, cells, folder)


def _overrides(file: Path) -> dict[str, str]:
    """Return item -> material of the person's own table; an empty material skips the item."""
    if not is_file(file):
        return {}
    overrides = {
        item: class_key(name) for item, name in read_names(file, "item", "material").items()
    }
    for item, material in overrides.items():
        if material and material not in MATERIALS:
            raise DataError(
                f"'{show(file)}' calls '{show(item)}' {show(material)}; expected"
                f" {', '.join(MATERIALS)} or nothing.{suggestion(material, MATERIALS)}"
            )
    return overrides


def material_of(
    item: str, caption: str, overrides: dict[str, str], *, strict: bool = False
) -> tuple[str, str]:
    """Return an item's material, or "" and the reason.

    An override has priority, then the item's name, then the caption. A text with two materials is
    ignored.
    """
    if item in overrides:
        return overrides[item], "" if overrides[item] else "left out by the table of materials"
    for text, glued in ((item, True), (caption, False)):
        found = rules_in_text(text, "tacquad", glued=glued)
        if len(found) > 1:
            return "", f"names {' and '.join(sorted(rule.named for rule in found))}"
        if found:
            return ruled(found[0], found[0].named, strict=strict)
    return "", "neither name nor caption has a material"


def _touches(contact: Contact, sensor: Sensor, left_out: Tally) -> Iterator[Pair]:
    """Yield the pairs of one sensor: the frames in contact, first and last included."""
    what = contact.by(sensor)
    bounds = contact.cells[sensor.column : sensor.column + 2]
    if len(bounds) < 2 or not all(map(str.isdecimal, bounds)) or int(bounds[0]) > int(bounds[1]):
        left_out.add(what, f"no range of frames in contact_{contact.part}.csv")
        return
    first, last = map(int, bounds)
    touch = frames_in(contact.folder / sensor.folder)
    inside = {number: file for number, file in touch.items() if first <= number <= last}
    if missing := last - first + 1 - len(inside):
        left_out.add(what, "frames of the range that are not there", missing)
    yield from _paired(contact, sensor, inside, len(touch), left_out)


def _paired(
    contact: Contact, sensor: Sensor, touch: dict[int, Path], recorded: int, left_out: Tally
) -> Iterator[Pair]:
    """Yield touch frames with the image of the same moment.

    recorded  number of all touch frames; the number of images may differ slightly, so frame t is
              paired with image int(t / recorded * images)
    """
    images = list(frames_in(contact.folder / f"img_{sensor.folder}").values())
    if touch and not images:
        left_out.add(contact.by(sensor), f"no images in img_{sensor.folder}", len(touch))
        return
    for number, file in touch.items():
        yield Pair(
            vis=images[min(number * len(images) // recorded, len(images) - 1)],
            tac=file,
            domain=sensor.domain,
            material=contact.material,
            object=contact.item,
            part=contact.part,
        )


def _with_splits(
    pairs: list[Pair], contact: Contact, sensor: Sensor, seed: int, all_frames: bool
) -> list[Pair]:
    """Return the training and test frames of an item, in recorded order."""
    outdoor = contact.part == "outdoor"
    wanted = len(pairs) if all_frames else min(len(pairs), TEST + TRAIN * outdoor)
    random = Random(derive_seed(seed, "frames", sensor.domain, contact.part, contact.item))
    order = random.sample(range(len(pairs)), wanted)
    tests = round(wanted * TEST / (TEST + TRAIN)) if outdoor else wanted
    split = {index: "test" if rank < tests else "train" for rank, index in enumerate(order)}
    return [replace(pairs[index], split=split[index]) for index in sorted(split)]


def _tac3d(contacts: list[Contact], folder: Path, seed: int, left_out: Tally) -> list[Pair]:
    """Return the pairs of Tac3D, which was recorded indoors and has no contact ranges."""
    fields = {
        contact.item: (contact, frames_in(contact.folder / TAC3D.folder, ARRAYS))
        for contact in contacts
        if contact.part == "indoor"
    }
    files = [file for _, frames in fields.values() for file in frames.values()]
    drawn = draw_all(files, folder)
    pairs: list[Pair] = []
    for item, (contact, frames) in fields.items():
        if not frames:
            left_out.add(contact.by(TAC3D), "no fields in tac3d")
        for file in frames.values():
            if file not in drawn:
                left_out.add(f"indoor/{show(item)}/tac3d/{show(file.name)}", "no 20 x 20 x 3 field")
        good = {number: file for number, file in frames.items() if file in drawn}
        found = list(_paired(contact, TAC3D, good, len(frames), left_out))
        random = Random(derive_seed(seed, "frames", TAC3D.domain, "indoor", item))
        tests = set(random.sample(range(len(found)), round(len(found) * T3D_TEST_SHARE)))
        pairs += [
            replace(pair, tac=drawn[pair.tac], split="test" if index in tests else "train")
            for index, pair in enumerate(found)
        ]
    return pairs


def _by_object(pairs: list[Pair], seed: int) -> list[Pair]:
    """Return the pairs with whole items in train or test; items for testing only stay so."""
    trained = {(pair.domain, pair.part) for pair in pairs if pair.split == "train"}
    split = [pair for pair in pairs if (pair.domain, pair.part) in trained]
    rest = [pair for pair in pairs if (pair.domain, pair.part) not in trained]
    return [*split_by_object(split, seed=seed, test=TEST / (TEST + TRAIN)), *rest]
