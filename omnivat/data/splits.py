"""Split pairs without dividing objects, and balance classes.

Pairs with the same object name belong to one object, which may be a clip or an item. A pair without
a name is a separate object.
"""

from collections import Counter, defaultdict
from collections.abc import Hashable, Sequence
from dataclasses import replace
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.pairs import Pair, Tally
from omnivat.kit.seeding import derive_seed


def hold_out(
    objects: Sequence[str], labels: Sequence[Hashable] | NDArray[Any], fraction: float, *, seed: int
) -> NDArray[np.bool_]:
    """Return a mask of the held-out pairs: whole objects, about `fraction` of each class.

    objects   N names; "" is a separate object
    labels    N classes, texts or numbers
    fraction  above 0 and below 1, of the pairs of each class
    seed      the same seed holds out the same pairs
    return    (N,) True where held out

    A class of two or more objects has pairs on both sides, unless objects of several classes
    prevent it. A class of one object is never held out.
    """
    names: list[Hashable] = [name or number for number, name in enumerate(objects)]
    classes: dict[Hashable, Counter[Hashable]] = defaultdict(Counter)
    for name, label in zip(names, labels, strict=True):
        classes[name][label] += 1
    held = _choose(classes, fraction, Random(seed))
    return np.fromiter((name in held for name in names), dtype=bool, count=len(names))


def _choose(
    objects: dict[Hashable, Counter[Hashable]], fraction: float, random: Random
) -> set[Hashable]:
    """Return objects that together hold about `fraction` of each class.

    Objects are visited in random order, and one is chosen if that brings its classes closer to
    their share. Then every class without one gets its smallest object, if it has another.
    """
    total, owners, taken, taken_owners = (Counter[Hashable]() for _ in range(4))
    for content in objects.values():
        total.update(content)
        owners.update(content.keys())
    held: set[Hashable] = set()

    def leaves_some(content: Counter[Hashable]) -> bool:
        return all(taken_owners[label] + 1 < owners[label] for label in content)

    def take(name: Hashable) -> None:
        held.add(name)
        taken.update(objects[name])
        taken_owners.update(objects[name].keys())

    order = list(objects)
    random.shuffle(order)
    for name in order:
        content = objects[name]
        gain = sum(
            (abs(taken[c] - fraction * total[c]) - abs(taken[c] + n - fraction * total[c]))
            / total[c]
            for c, n in content.items()
        )
        if gain > 0 and leaves_some(content):
            take(name)
    for label in [label for label in total if not taken[label]]:
        fitting = [
            n for n in order if n not in held and label in objects[n] and leaves_some(objects[n])
        ]
        if fitting and not taken[label]:
            take(min(fitting, key=lambda name: objects[name].total()))
    return held


def split_by_object(pairs: Sequence[Pair], *, seed: int, test: float) -> tuple[Pair, ...]:
    """Return the pairs with split train or test, without dividing objects.

    test  fraction of the pairs of each class in each domain
    seed  of the draw; a domain's draw does not depend on the other domains
    """
    made = list(pairs)
    for domain in dict.fromkeys(pair.domain for pair in pairs):
        rows = [i for i, pair in enumerate(pairs) if pair.domain == domain]
        objects, materials = [pairs[i].object for i in rows], [pairs[i].material for i in rows]
        held = hold_out(objects, materials, test, seed=derive_seed(seed, "test", domain))
        for index, tests in zip(rows, held, strict=True):
            made[index] = replace(pairs[index], split="test" if tests else "train")
    return tuple(made)


def balance(pairs: Sequence[Pair], left_out: Tally, *, seed: int) -> tuple[Pair, ...]:
    """Draw from each class as many pairs as the smallest class has, in every domain and split.

    left_out  counts the pairs removed from each class
    seed      of the draw; a class's draw depends on the others only by the size
    """
    groups: dict[tuple[str, str], dict[str, list[int]]] = defaultdict(lambda: defaultdict(list))
    for index, pair in enumerate(pairs):
        groups[pair.domain, pair.split][pair.material].append(index)
    keep: set[int] = set()
    for (domain, split), classes in groups.items():
        smallest = min(map(len, classes.values()))
        for material, members in classes.items():
            keep.update(
                Random(derive_seed(seed, "balance", domain, split, material)).sample(
                    members, smallest
                )
            )
            if extra := len(members) - smallest:
                what = (
                    f"{domain}{' ' if split else ''}{split}: {extra} of {len(members)} {material}"
                )
                left_out.add(what, "balanced to the smallest class", extra)
    return tuple(pair for index, pair in enumerate(pairs) if index in keep)
