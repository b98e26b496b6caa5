"""A pair: a photo (VIS) and a tactile image (TAC) of one contact, with its names."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """One VIS + TAC pair on disk. `object` is the thing touched: splits keep objects whole."""

    vis: Path
    tac: Path
    domain: str
    material: str
    object: str = ""
    split: str = ""  # "train", "test" or "" where the source states none
    part: str = ""  # TacQuad: "indoor" or "outdoor"
    tac_crop: int = 0  # central square to cut before resizing, pixels; 0 cuts nothing


@dataclass(frozen=True, slots=True, kw_only=True)
class Skipped:
    """Something a reader left out, and why."""

    what: str
    why: str


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

    def counts(self) -> Counter[tuple[str, str, str]]:
        """Return how many pairs each (domain, split, material) has."""
        return Counter((pair.domain, pair.split, pair.material) for pair in self.pairs)
