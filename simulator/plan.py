"""The plan of a simulated set: names, objects, splits and imitations; and the table of its
pairs.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from omnivat.data.domains import simulated
from omnivat.data.materials import MATERIALS
from omnivat.data.pairs import TEXTS, Pair
from omnivat.kit.files import write_csv
from omnivat.kit.stages import IMAGES
from simulator.domains import SimulatedDomain

COLUMNS = ("vis", "tac", "domain", "material", *TEXTS)
PAIRS = 60  # of each class of each domain in the shipped set
TEST_EVERY = 3  # one object of three is a test object
LOOK_ALIKES = 0.25  # of the objects imitate another class by sight
FEEL_ALIKES = 0.10  # of the objects of the classes below imitate another class by touch
# Smooth surfaces feel alike: polished glass, glazed ceramic, polished steel, glossy plastic.
SMOOTH = ("steel", "plastic", "ceramic", "glass")
_STEPS = (0.7548776662, 0.4142135624, 0.5698402910)  # of rotations: sight, touch, which class


@dataclass(frozen=True, slots=True, kw_only=True)
class Planned:
    """One pair to draw."""

    made: SimulatedDomain
    material: str
    object: str
    number: int  # of the object, unique within its material over all domains
    split: str
    part: str
    looks_like: str = ""  # the class that the object imitates by sight
    feels_like: str = ""  # the class that it imitates by touch
    twin_of: "Planned | None" = None  # whose object and press it shows; None: its own

    @property
    def domain(self) -> str:
        """The domain's name."""
        return self.made.name


def planned(domain: SimulatedDomain, material: str, *, pairs: int) -> list[Planned]:
    """Return the pairs of one class of one domain, each of a different object.

    Consecutive numbers have a balanced mixture of surfaces and imitations. Each split of each part
    has consecutive numbers, so training and test objects have the same mixture.
    """
    parts = domain.series or ("",)
    places = [
        (
            "test" if index // len(parts) % TEST_EVERY == 1 else "train",
            parts[index % len(parts)],
            index,
        )
        for index in range(pairs)
    ]
    numbers = {place: domain.seed_base + rank for rank, place in enumerate(sorted(places))}
    found = []
    for place in places:
        split, part, index = place
        looks, feels = imitated(domain, material, numbers[place])
        found.append(Planned(
            made=domain, material=material, number=numbers[place], split=split, part=part,
            object=f"{simulated(domain.name)}/{material}-{index:02d}",
            looks_like=looks, feels_like=feels,
        ))  # fmt: skip
    return found


def write_table(out: Path, pairs: Iterable[Pair], columns: Sequence[str] = COLUMNS) -> None:
    """Write `<out>/pairs.csv`, with paths relative to the set."""
    rows = []
    for pair in pairs:
        files = {name: getattr(pair, name).relative_to(out).as_posix() for name in IMAGES}
        rows.append([files.get(name) or getattr(pair, name) for name in columns])
    write_csv(out / "pairs.csv", columns, rows)


def imitated(domain: SimulatedDomain, material: str, number: int) -> tuple[str, str]:
    """Return the classes that an object imitates by sight and by touch, "" for none.

    No object imitates in both ways, so one modality always shows its class. Only classes of the
    same domain are imitated. The choice depends on the number only, by rotations with steps
    unrelated to those of the recipes.
    """
    here = classes(domain)
    looks = [name for name in IMITATIONS.get(material, ()) if name in here]
    feels = [name for name in SMOOTH if name != material and name in here]
    start = MATERIALS.index(material) / len(MATERIALS)
    sight, touch, which = ((number * step + start) % 1.0 for step in _STEPS)
    if looks and sight < LOOK_ALIKES:
        return looks[int(which * len(looks))], ""
    if material in SMOOTH and touch < FEEL_ALIKES / (1.0 - LOOK_ALIKES):
        return "", feels[int(which * len(feels))]
    return "", ""


def classes(domain: SimulatedDomain) -> tuple[str, ...]:
    """Return the materials of a domain."""
    return tuple(name for name in MATERIALS if domain.ceramic or name != "ceramic")


IMITATIONS: dict[str, tuple[str, ...]] = {
    "wood": ("plastic", "ceramic", "steel"),  # painted, matt or glossy; metallic lacquer
    "steel": ("plastic", "ceramic", "wood"),  # powder coat; enamel; film with a picture of wood
    "plastic": ("wood", "steel", "glass", "ceramic"),  # laminate; faux metal; clear; melamine
    "ceramic": ("wood", "plastic", "steel"),  # wood-look tile; matt glaze; metallic glaze
    "glass": ("plastic", "ceramic", "steel"),  # dyed and opaque; milk glass; silvered
}
EMBOSSED = 0.3  # share of the imitated relief in an imitation
OTHER_SHAPE = 0.7  # share of the imitations with a shape of the imitated class
