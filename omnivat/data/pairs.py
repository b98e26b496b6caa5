"""A pair: a photo (VIS) and a tactile image (TAC) of one contact, with its names."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from omnivat.data.materials import in_order
from omnivat.errors import printable


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """One VIS + TAC pair on disk. `object` is the thing touched: splits keep objects whole."""

    vis: Path
    tac: Path
    domain: str
    material: str
    object: str = ""
    split: str = ""  # "train", "val", "test" or "" where the source states none
    part: str = ""  # TacQuad: "indoor" or "outdoor"
    looks_like: str = ""  # the class that the object imitates by sight, "" where none
    feels_like: str = ""  # the class that it imitates by touch, "" where none
    tac_crop: int = 0  # central square to cut before resizing, pixels; 0 cuts nothing


@dataclass(frozen=True, slots=True, kw_only=True)
class Skipped:
    """Something a reader left out, and why. `count` is how many such things it stands for."""

    what: str
    why: str
    count: int = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class PairSet:
    """What a reader found: the pairs, what it left out, and where they come from."""

    pairs: tuple[Pair, ...]
    skipped: tuple[Skipped, ...] = field(default=())
    origin: str = ""  # one line for people, such as "Touch-and-Go, official lists"
    simulated: bool = False

    def domains(self) -> tuple[str, ...]:
        """Return the domains in the order they first appear."""
        return tuple(dict.fromkeys(pair.domain for pair in self.pairs))

    def materials(self) -> tuple[str, ...]:
        """Return the classes: the five materials first, in their usual order, then the others."""
        return in_order({pair.material for pair in self.pairs})

    def counts(self) -> Counter[tuple[str, str, str]]:
        """Return how many pairs each (domain, split, material) has."""
        return Counter((pair.domain, pair.split, pair.material) for pair in self.pairs)


def summary_table(found: PairSet, *, examples: int = 3) -> str:
    """Return what was loaded, what was skipped and why, as text tables with named columns.

    found     what a reader returned
    examples  how many skipped things to name for each reason
    return    lines for people, without a final line end
    """
    classes = found.materials()
    places = Counter((p.domain, p.part, p.split, p.material) for p in found.pairs)
    rows = [
        [domain, part or "-", split or "-", *map(str, numbers), str(sum(numbers))]
        for domain, part, split in dict.fromkeys((p.domain, p.part, p.split) for p in found.pairs)
        for numbers in [[places[domain, part, split, name] for name in classes]]
    ]
    simulated = " (simulated)" if found.simulated else ""
    lines = [f"{len(found.pairs)} pairs from {printable(found.origin or 'no origin')}{simulated}"]
    if rows:
        lines += _aligned(["domain", "part", "split", *classes, "pairs"], rows)
    if found.skipped:
        lines += ["", *_aligned(["skipped", "why", "for example"], _reasons(found, examples))]
    return "\n".join(lines)


def _reasons(found: PairSet, examples: int) -> list[list[str]]:
    by_reason: dict[str, list[Skipped]] = {}
    for skipped in found.skipped:
        by_reason.setdefault(skipped.why, []).append(skipped)
    return [
        [
            str(sum(skipped.count for skipped in group)),
            why,
            "; ".join(skipped.what for skipped in group[:examples])
            + (f"; and {len(group) - examples} more" if len(group) > examples else ""),
        ]
        for why, group in by_reason.items()
    ]


def _aligned(header: list[str], rows: list[list[str]]) -> list[str]:
    """Return the lines of a table whose columns are as wide as their longest cell."""
    table = [[printable(cell) for cell in row] for row in [header, *rows]]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in table]
