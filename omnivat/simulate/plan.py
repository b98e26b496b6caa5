"""Which pairs a simulated set has: names, objects, splits and parts, before anything is drawn."""

from dataclasses import dataclass

from omnivat.data.domains import DOMAINS, Domain, simulated
from omnivat.data.materials import MATERIALS

TEST_SHARE = 0.3  # of the objects


@dataclass(frozen=True, slots=True, kw_only=True)
class Planned:
    """One pair to draw."""

    domain: str  # the paper's name
    material: str
    object: str
    number: int  # of the object, unique within its material over all domains
    split: str
    part: str
    stem: str

    def folder(self) -> str:
        """Return where the pair goes, relative to the set."""
        return f"{simulated(self.domain)}/{self.material}"


def planned(domain: Domain, material: str, *, pairs: int) -> list[Planned]:
    """Return the pairs of one class of one domain, each of an object of its own.

    Neighbouring numbers hold a fair mixture of surfaces, so each split of each part gets a run of
    them: what is asked about is of the same kinds as what was trained on.
    """
    parts = domain.series or ("",)
    places = [
        ("test" if _is_test(index // len(parts)) else "train", parts[index % len(parts)], index)
        for index in range(pairs)
    ]
    first = list(DOMAINS).index(domain.name) * 10_000
    numbers = {place: first + rank for rank, place in enumerate(sorted(places))}
    plan = []
    for place in places:
        split, part, index = place
        name = f"{material}-{index:02d}"
        plan.append(
            Planned(
                domain=domain.name,
                material=material,
                object=f"{simulated(domain.name)}/{name}",
                number=numbers[place],
                split=split,
                part=part,
                stem=name,
            )
        )
    return plan


def _is_test(turn: int) -> bool:
    """Spread the test objects evenly: 3 of every 10, the first of them early."""
    return int((turn + 1) * TEST_SHARE + 0.5) > int(turn * TEST_SHARE + 0.5)


def classes(domain: Domain) -> tuple[str, ...]:
    """Return the materials that a domain has."""
    return tuple(name for name in MATERIALS if domain.ceramic or name != "ceramic")
