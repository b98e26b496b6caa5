"""Which pairs a simulated set has: names, objects, splits and parts, before anything is drawn."""

from dataclasses import dataclass

from omnivat.data.domains import DOMAINS, Domain, simulated
from omnivat.data.materials import MATERIALS

PRESSES = 2  # pairs that share one object
TEST_SHARE = 0.3  # of the objects


@dataclass(frozen=True, slots=True, kw_only=True)
class Planned:
    """One pair to draw."""

    domain: str  # the paper's name
    material: str
    object: str
    number: int  # of the object, unique within its material over all domains
    press: int
    split: str
    part: str
    stem: str

    def folder(self) -> str:
        """Return where the pair goes, relative to the set."""
        return f"{simulated(self.domain)}/{self.material}"


def planned(domain: Domain, material: str, *, pairs: int) -> list[Planned]:
    """Return the pairs of one class of one domain; objects are whole within a split and a part."""
    objects = max(1, (pairs + PRESSES - 1) // PRESSES)
    first = list(DOMAINS).index(domain.name) * 10_000
    parts = domain.series or ("",)
    plan: list[Planned] = []
    for index in range(objects):
        part = parts[index % len(parts)]
        turn = index // len(parts)  # the object's place within its part
        split = "test" if _is_test(turn) else "train"
        name = f"{material}-{index:02d}"
        plan += [
            Planned(
                domain=domain.name,
                material=material,
                object=f"{simulated(domain.name)}/{name}",
                number=first + index,
                press=press,
                split=split,
                part=part,
                stem=f"{name}_{press}",
            )
            for press in range(PRESSES)
        ]
    return plan[:pairs]


def _is_test(turn: int) -> bool:
    """Spread the test objects evenly: 3 of every 10, the first of them early."""
    return int((turn + 1) * TEST_SHARE + 0.5) > int(turn * TEST_SHARE + 0.5)


def classes(domain: Domain) -> tuple[str, ...]:
    """Return the materials that a domain has."""
    return tuple(name for name in MATERIALS if domain.ceramic or name != "ceramic")
