"""What may be known of a new sensor, as rows: the rungs of the ladder.

A row is all that there is to a rung: what is known, in words and numbers, and where the page shows
it. The page receives the rows (`app/shared/tables.py`), and no script names one of them.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from omnivat.kit.config import is_count
from omnivat.kit.errors import DataError

if TYPE_CHECKING:
    from omnivat.data.embeddings import Embeddings

ALL = 1_000_000  # pairs: every one that there is
DRAWS = 10  # of known pairs, over which results are averaged
FEW = 20  # pairs without labels, where a set has as many
Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Known:
    """What is known of every target; `pairs`, `labels`, `sensors` and `NOTHING` make it."""

    name: str  # short, for records
    words: str
    pairs: int = 0  # without labels
    labels: int = 0  # labelled pairs of each class
    sensors: int = 1  # source domains
    rested: "Embeddings | None" = field(default=None, compare=False)  # in place of the set
    # how: stream, seed, domain and pool -> the pool in the order in which it becomes known
    draw: Callable[[str, int, str, Any], Any] | None = field(default=None, compare=False)

    def seeds(self, first: int, draws: int) -> range:
        """Return the seed of each draw; of one where nothing is drawn."""
        random = self.pairs or self.labels or self.sensors > 1
        return range(first, first + (draws if random else 1))


NOTHING = Known("none", "nothing: pictures as they come")


def pairs(count: int, *, every: bool = False) -> Known:
    """Return `count` training pairs of each target without labels; `every`: all that there are.

    Raises DataError for anything but a whole number from 0, as `labels` does.

    >>> pairs(5).words, pairs(1_000_000, every=True).words
    ('5 pairs without labels', 'all pairs without labels')
    """
    _require_count(count, "pairs without labels")
    name, number = ("all", "all") if every else (f"n{count}", str(count))
    return Known(name, f"{number} pair{'s' * (count != 1)} without labels", pairs=count)


def labels(count: int) -> Known:
    """Return `count` labelled training pairs of each class of each target.

    >>> labels(3).words
    '3 labelled pairs of each class'
    """
    _require_count(count, "labelled pairs of each class")
    words = f"{count} labelled pair{'s' * (count != 1)} of each class"
    return Known(f"k{count}", words, labels=count)


def _require_count(count: Any, what: str) -> None:
    if not is_count(count):
        raise DataError(f"{count!r:.40} {what} cannot be known; choose a whole number from 0.")


def sensors(count: int, *, profiles: bool = False) -> Known:
    """Return `count` source domains: the source, and others than it and the target, drawn.

    profiles  each domain is moved by the profile of all its training pairs

    >>> sensors(4, profiles=True).words
    '4 source domains and all pairs without labels'
    """
    more = " and all pairs without labels" * profiles
    name, words = f"m{count}{'+' * profiles}", f"{count} source domains{more}"
    return Known(name, words, pairs=ALL * profiles, sensors=count)


def _row(known: Known, **more: Any) -> Row:
    """Return the row of what a head is measured with."""
    own = {"id": known.name, "words": known.words, "pairs": known.pairs, "labels": known.labels}
    return own | more


def known_of(row: Row) -> Known | None:
    """Return what a head is measured with; None for a row that no head of one source climbs."""
    if not row.keys() & {"pairs", "labels"}:
        return None
    return Known(row["id"], row["words"], row.get("pairs", 0), row.get("labels", 0))


# id, words      in records and addresses; what is known, `brief` in a line of several
# pairs, labels  of each target, as in `Known`; a row that has neither is read from records
# home           measured on the source in place of the targets
# bar            its name among the bars of a visitor's own set
# step           of the line of *Try a pair* that names its gain: 2 before labels, 3 before teaching
# map            the number of the twins' map that it draws
# title, help    of its button above the map, and `remark` below: {apart} of sensors, {first} as
#                they come, {gain} in points
RUNGS: list[Row] = [
    _row(NOTHING, id="home", words="its own sensor", home=True, bar="training domain"),
    _row(
        NOTHING,
        brief="nothing from the new sensor",
        bar="new domains",
        map=0,
        title="Raw features",
        remark="The lines join one press as seen by all eight sensors."
        " Mean distance between sensors: {apart}.",
    ),
    {
        "id": "mean",
        "words": "each sensor’s mean",
        "map": 1,
        "title": "Align means",
        "brief": "the mean of each sensor’s features",
        "help": "Move each sensor’s mean to the mean of all sensors",
        "remark": "Mean distance between sensors: {apart} instead of {first}. {gain}",
    },
    {
        "id": "spread",
        "words": "each sensor’s mean and spread",
        "map": 2,
        "title": "Align means and spreads",
        "brief": "the mean and the spread of each sensor’s features",
        "help": "Also scale each feature of a sensor to the spread of all sensors",
        "remark": "Sensors shift and stretch features."
        " Aligning means and spreads undoes both. {gain}",
    },
    *(_row(pairs(count)) for count in (1, 2, 5, 10)),
    _row(pairs(20), step=2, bar="with pictures"),
    _row(pairs(50)),
    _row(pairs(ALL, every=True)),
    _row(labels(1)),
    _row(labels(3), step=3, bar="with labels"),
    _row(labels(5)),
    *(
        {"id": known.name, "words": known.words}
        for profiles in (False, True)
        for known in (sensors(m, profiles=profiles) for m in (2, 4, 7))
    ),
]
