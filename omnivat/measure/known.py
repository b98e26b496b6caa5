"""One measurement: what a head reads right in domains that it has not met, by what is known of
them.

`measured` draws the known pairs, leaves them out of the test, and averages over draws. `evaluate`,
the ladder, `try` and Python users call it:

    measured(head, embeddings)                      # nothing is known
    measured(head, embeddings, pairs(5), draws=10)  # five pairs without labels: a profile
    measured(head, embeddings, labels(3))           # three labelled pairs of each class: taught

Two things that one may know are no `Known`. The number of source sensors is a fact of the head:
train heads of other sources and measure each. A picture of the sensor at rest changes pictures
before they are embedded: embed them with and without it, and measure both sets.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings
from omnivat.data.profile import drawn_profiles, profile_of, profiled
from omnivat.head.checkpoint import Head
from omnivat.head.teach import Lesson, taught
from omnivat.kit.errors import DataError
from omnivat.kit.seeding import derive_seed
from omnivat.kit.stages import IMAGES
from omnivat.measure.evaluate import inputs_of, label_map, predicted_probabilities
from omnivat.measure.unseen import counted, interval

DRAWS = 10
Array = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Known:
    """What is known of every target domain; `pairs`, `labels` and `NOTHING` make it."""

    name: str  # short, for records
    words: str
    pairs: int = 0  # without labels
    labels: int = 0  # labelled pairs of each class


NOTHING = Known("none", "nothing: pictures as they come")


def pairs(count: int, *, every: bool = False) -> Known:
    """Return `count` training pairs of each target without labels; `every`: all that there are."""
    name, number = ("all", "all") if every else (f"n{count}", str(count))
    return Known(name, f"{number} pair{'s' * (count != 1)} without labels", pairs=count)


def labels(count: int) -> Known:
    """Return `count` labelled training pairs of each class of each target."""
    words = f"{count} labelled pair{'s' * (count != 1)} of each class"
    return Known(f"k{count}", words, labels=count)


@dataclass(frozen=True, slots=True, kw_only=True)
class Draw:
    """The pairs of a set that are left to predict, after the known ones were drawn."""

    embeddings: Embeddings  # moved by the targets' profiles
    rows: NDArray[np.int64]  # (n,) their places in the set
    pictures: dict[str, int]  # domain -> pairs of its profile


def drawn(head: Head, embeddings: Embeddings, count: int, *, seed: int = 0) -> Draw:
    """Draw `count` pairs of each target without labels; return the rest, moved by their profiles.

    Raises DataError for a negative count, or a head without its source's profile.

    >>> from omnivat import default_embeddings, default_head, load_embeddings, load_head
    >>> head, pairs = load_head(default_head()), load_embeddings(default_embeddings())
    >>> drawn(head, pairs, 5).pictures["OF Real-sim"]
    5
    """
    profiles, known = drawn_profiles(embeddings, head.source, count, seed=seed)
    rest = np.setdiff1d(np.arange(len(embeddings)), known)
    moved = embeddings.select(rest)
    if profiles:
        moved = profiled(moved, profiles, head.source_profile)
    pictures = {name: profile.counts["vis"] for name, profile in profiles.items()}
    return Draw(embeddings=moved, rows=rest, pictures=pictures)


def measured(
    head: Head,
    embeddings: Embeddings,
    known: Known = NOTHING,
    *,
    draws: int = DRAWS,
    seed: int = 0,
    home: bool = False,
) -> dict[str, Any]:
    """Return the accuracy of both images in every domain but the source, as a record.

    known  drawn from each target's training pairs, `draws` times with seeds `seed`, `seed` + 1, ...
    home   measure the source in place of the targets

    The record: "rung" and "known" (name and words), "accuracy" (mean over domains of the share of
    right test pairs), "low" and "high" (95 % interval; domains and pairs are drawn), "pairs",
    "domains" (share by domain) and "draws" (the accuracy of each draw). Pairs of a class that the
    head lacks are left out. Raises DataError for embeddings of another encoder, or without a test
    pair to predict.

    >>> from omnivat import default_embeddings, default_head, load_embeddings, load_head
    >>> head, embeddings = load_head(default_head()), load_embeddings(default_embeddings())
    >>> for known in (NOTHING, pairs(20), labels(3)):
    ...     found = measured(head, embeddings, known, draws=1)
    ...     print(found["known"], found["low"] < found["accuracy"] < found["high"])
    nothing: pictures as they come True
    20 pairs without labels True
    3 labelled pairs of each class True
    """
    head.require_embeddings(embeddings)
    once = not (known.pairs or known.labels)
    right = np.stack(
        [_right(head, embeddings, known, seed + k) for k in range(1 if once else draws)]
    )
    source = np.array([name == head.source for name in embeddings.header.domains])
    right[:, source[embeddings.domain] != home] = np.nan
    if np.isnan(right).all():
        where = f"of '{head.source}', which needs a split" if home else "of any other domain"
        raise DataError(
            f"No test pair {where} is of a class that the head learned:"
            f" {', '.join(head.settings.classes[:5])}{' …' * (len(head.settings.classes) > 5)}."
        )
    return {"rung": known.name, "known": known.words} | record(
        right, embeddings.domain, embeddings.header.domains
    )


def record(right: Array, domain: NDArray[np.int64], names: Sequence[str]) -> dict[str, Any]:
    """Return accuracy and interval of right predictions (draws, N); NaN where none was made."""
    made = ~np.isnan(right).all(0)
    mean = np.where(made, np.nan_to_num(right).sum(0) / np.maximum((~np.isnan(right)).sum(0), 1), 0)
    masks = {names[d]: made & (domain == d) for d in np.unique(domain[made])}
    counts = [(round(float(mean[rows].sum())), int(rows.sum())) for rows in masks.values()]
    low, high = interval(counts)
    shares = {name: float(mean[rows].mean()) for name, rows in masks.items()}
    of_draws = [[row[rows] for rows in masks.values()] for row in right]
    each = [[np.nanmean(own) for own in row if not np.isnan(own).all()] for row in of_draws]
    return {
        "accuracy": float(np.mean(list(shares.values()))),
        "low": low,
        "high": high,
        "pairs": int(made.sum()),
        "domains": shares,
        "draws": [float(np.mean(shares)) for shares in each],
    }


def _right(head: Head, embeddings: Embeddings, known: Known, seed: int) -> Array:
    """Return (N,) 1 for a right prediction, 0 for a wrong one, NaN for a pair that is not
    tested.
    """
    label = label_map(head.settings.classes, embeddings.header.classes)[embeddings.label]
    tested = counted(embeddings, head.source) & (label >= 0)
    right = np.full(len(embeddings), np.nan)
    parts = (
        _taught(head, embeddings, known.labels, seed)
        if known.labels
        else [(head, drawn(head, embeddings, known.pairs, seed=seed))]
    )
    for judge, draw in parts:
        keep = tested[draw.rows]
        if keep.any():
            some, rows = draw.embeddings.select(keep), draw.rows[keep]
            shares = predicted_probabilities(judge.model, some, modalities=inputs_of(head))["fused"]
            named = label_map(embeddings.header.classes, judge.settings.classes)
            right[rows] = named[shares.argmax(1).numpy()] == embeddings.label[rows]
    return right


def _taught(
    head: Head, embeddings: Embeddings, count: int, seed: int
) -> Iterator[tuple[Head, Draw]]:
    """Yield, for each target, a head that labelled pairs of it taught, and its other pairs."""
    for name in embeddings.header.domains:
        pool = embeddings.rows_of(name, split="train")
        pool = pool[embeddings.label[pool] >= 0]
        if name == head.source or not len(pool):
            continue
        random = np.random.default_rng(derive_seed(seed, "labelled", name))
        mixed = random.permutation(pool)
        label = embeddings.label[mixed]
        some = np.concatenate([mixed[label == c][:count] for c in np.unique(label)])
        profile = profile_of(embeddings, np.sort(some), domain=name)
        near = profiled(embeddings, {name: profile}, head.source_profile)
        lessons = [
            Lesson(
                label=embeddings.header.classes[embeddings.label[row]],
                object=embeddings.rows["object"][row],
                **{
                    n: torch.from_numpy(np.array(getattr(near, n)[row], np.float32))[None]
                    for n in IMAGES
                },
            )
            for row in some
        ]
        rest = np.setdiff1d(embeddings.rows_of(name), some)
        yield (
            taught(head, lessons),
            Draw(embeddings=near.select(rest), rows=rest, pictures={name: len(some)}),
        )
