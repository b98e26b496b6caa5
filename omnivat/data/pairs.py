"""A pair: a photo (VIS) and a tactile image (TAC) of one contact, with names."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from omnivat.data.materials import NO_CLASS, in_order
from omnivat.kit.errors import DataError, printable
from omnivat.kit.stages import IMAGES

TEXTS = ("object", "split", "part", "looks_like", "feels_like")  # of a pair, or ""
NAMED = 3  # reasons in an error; skipped items named for a reason


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """One VIS + TAC pair on disk. `object` is the touched object; no split divides it."""

    vis: Path
    tac: Path
    domain: str
    material: str
    object: str = ""
    split: str = ""  # "train", "val", "test", or "" without a split
    part: str = ""  # TacQuad: "indoor" or "outdoor"
    looks_like: str = ""  # the class that the object imitates visually, or ""
    feels_like: str = ""  # the class that it imitates by touch, or ""
    tac_crop: int = 0  # central square before resizing, pixels; 0: no crop
    tac_rest: Path | None = None  # picture of the untouched sensor, to be subtracted
    tac_way: str = ""  # how its touch is turned and its channels are (`omnivat.data.arranged`)
    tac_before: Path | None = None  # tactile image of a moment before, for encoders that take one
    alone: str = ""  # "vis" or "tac": the only picture, which stands for both
    numbers: tuple[tuple[str, str], ...] = ()  # other columns, such as a force, and their texts


@dataclass(frozen=True, slots=True, kw_only=True)
class Skipped:
    """Something that a reader skipped, and the reason. `count` is the number of such items."""

    what: str
    why: str
    count: int = 1


class Tally:
    """Counts skipped pairs by item and reason, so that a hundred thousand frames give a few
    lines.
    """

    def __init__(self) -> None:
        self._counts: Counter[tuple[str, str]] = Counter()

    def add(self, what: str, why: str, count: int = 1) -> None:
        """Count `count` pairs of `what`, skipped because of `why`."""
        self._counts[what, why] += count

    def result(
        self, name: str, source: Path, pairs: Sequence["Pair"], how: str, *, simulated: bool = False
    ) -> "PairSet":
        """Return the result of the reader of the data set `name`; `how` it was read is its origin.

        Raises DataError with the most frequent reasons if there are no pairs.
        """
        if not pairs:
            reasons: Counter[str] = Counter()
            for (_, why), count in self._counts.items():
                reasons[why] += count
            named = [f"{why} ({count})" for why, count in reasons.most_common(NAMED)]
            left_out = f" Left out: {'; '.join(named)}." if named else ""
            raise DataError(f"No pairs of {name} in '{source}'.{left_out}")
        skipped = [Skipped(what=w, why=why, count=n) for (w, why), n in self._counts.items()]
        return PairSet(
            pairs=tuple(pairs), skipped=tuple(skipped), origin=f"{name}, {how}", simulated=simulated
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PairSet:
    """The result of a reader: pairs, skipped items, and their origin.

    >>> wood = Pair(vis=Path("1_vis.png"), tac=Path("1_tac.png"), domain="TAG", material="wood")
    >>> glass = Pair(vis=Path("2_vis.png"), tac=Path("2_tac.png"), domain="TAG", material="glass")
    >>> mine = PairSet(pairs=(glass, wood), origin="my bench")
    >>> mine.domains(), mine.materials()
    (('TAG',), ('wood', 'glass'))
    """

    pairs: tuple[Pair, ...]
    skipped: tuple[Skipped, ...] = field(default=())
    origin: str = ""  # one line, such as "Touch-and-Go, official lists"
    simulated: bool = False

    def domains(self) -> tuple[str, ...]:
        """Return the domains in order of first appearance."""
        return tuple(dict.fromkeys(pair.domain for pair in self.pairs))

    def modalities(self) -> tuple[str, ...]:
        """Return the modalities that every pair has."""
        return modalities_of(pair.alone for pair in self.pairs)

    def materials(self) -> tuple[str, ...]:
        """Return the classes: the five materials first, in their usual order, then the others."""
        return in_order({pair.material for pair in self.pairs})


def modalities_of(alone: Iterable[str]) -> tuple[str, ...]:
    """Return the modalities that all of some pairs have, by the `alone` of each."""
    named = {*alone} - {""}
    return tuple(half for half in IMAGES if named <= {half})


def summary_table(pairs: PairSet) -> str:
    """Return what a person checks of loaded pairs, as lines of text: pairs, objects, splits,
    domains and classes, objects on both sides of a split, and what was left out and why.
    """
    classes = pairs.materials()
    places = Counter((p.domain, p.part, p.split, p.material) for p in pairs.pairs)
    things: dict[tuple[str, ...], set[str]] = defaultdict(set)
    splits: dict[tuple[str, str], set[str]] = defaultdict(set)
    for number, p in enumerate(pairs.pairs):
        things[p.domain, p.part, p.split].add(p.object or f"\0{number}")
        if p.object and p.split:
            splits[p.domain, p.object].add(p.split)
    rows = [
        [domain, part or "-", split or "-", *map(str, numbers), str(sum(numbers)), str(len(names))]
        for (domain, part, split), names in things.items()
        for numbers in [[places[domain, part, split, name] for name in classes]]
    ]
    simulated = " (simulated)" if pairs.simulated else ""
    alone = {"vis": "; photos alone", "tac": "; touches alone"}.get(
        "+".join(pairs.modalities()), ""
    )
    lines = [
        f"{len(pairs.pairs)} pairs from {printable(pairs.origin or 'no origin')}{simulated}{alone}"
    ]
    if rows:
        lines += _aligned(["domain", "part", "split", *classes, "pairs", "objects"], rows)
    homes: dict[str, set[str]] = defaultdict(set)
    for p in pairs.pairs:
        homes[p.material].add(p.domain)
    apart = len(classes) > 1 and all(len(found) == 1 for found in homes.values())
    if len(pairs.domains()) > 1 and (apart or classes == (NO_CLASS,)):
        lines.append(
            "no class is in two domains, so none is tested across domains; if your folders are"
            " classes, put them into one folder, which names their domain"
        )
    nameless = sum(not p.object for p in pairs.pairs)
    if 0 < nameless < len(pairs.pairs):
        lines.append(
            f"{nameless} pairs name no object, and others do; each counts as its own object"
        )
    if divided := [name for (_, name), found in splits.items() if len(found) > 1]:
        lines.append(
            f"objects in more than one split: {len(divided)}, such as '{printable(divided[0])}'"
        )
    if pairs.skipped:
        lines += ["", *_aligned(["skipped", "why", "for example"], _reasons(pairs))]
    return "\n".join(lines)


def _reasons(pairs: PairSet) -> list[list[str]]:
    by_reason: dict[str, list[Skipped]] = {}
    for skipped in pairs.skipped:
        by_reason.setdefault(skipped.why, []).append(skipped)
    rows = []
    for why, group in by_reason.items():
        more = [f"and {len(group) - NAMED} more"] if len(group) > NAMED else []
        named = "; ".join([*(skip.what for skip in group[:NAMED]), *more])
        rows.append([str(sum(skip.count for skip in group)), why, named])
    return rows


def _aligned(header: list[str], rows: list[list[str]]) -> list[str]:
    """Return the lines of a table with aligned columns."""
    table = [[printable(cell) for cell in row] for row in [header, *rows]]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in table]
