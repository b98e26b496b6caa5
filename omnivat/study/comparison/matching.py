"""The same pairs in several sets: rows in one order, or a sentence on what differs."""

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import PurePath
from typing import Any

import numpy as np

from omnivat.data.embeddings import Embeddings
from omnivat.kit.errors import DataError, printable
from omnivat.study.shift.reading import Features

_NUMBERED = re.compile(r"(.*/)?\d+(_vis|_tac)?")  # names that `import` gives to rows without one
Key = tuple[str, ...]


def matched(sets: Mapping[str, Features], view: str = "") -> dict[str, Features]:
    """Return the sets with the pairs of each in the order of the first, and the modalities that all
    have.

    view  "vis" or "tac": that one alone

    Pairs are known by domain, class, split, object and file names, as far as all sets name them; if
    several have one name, the order decides. Raises DataError for other pairs.
    """
    shared = tuple(m for m in ("vis", "tac") if all(m in s.modalities for s in sets.values()))
    if not (kept := tuple(m for m in shared if view in ("", m))):
        has = "; ".join(f"'{printable(n)}' has {'+'.join(s.modalities)}" for n, s in sets.items())
        raise DataError(f"The sets share no {view or 'modality'}: {has}. Choose others.")
    columns = [c for c in ("object", "vis", "tac", "split") if _named(sets, c)]
    keys = {name: _keys(features, columns) for name, features in sets.items()}
    (first, wanted), *others = keys.items()
    for name, own in others:
        _require_same(first, wanted, name, own)
    unique = len({*wanted}) == len(wanted)
    found = {}
    for name, features in sets.items():
        place = {key: k for k, key in enumerate(keys[name])}
        rows = np.array([place[key] for key in wanted]) if unique else np.arange(len(wanted))
        data = _unpadded(features.embeddings.select(rows), kept)
        found[name] = replace(features, embeddings=data, modalities=kept)
    return found


def _unpadded(data: Embeddings, kept: tuple[str, ...]) -> Embeddings:
    """Leave out the zeros that make an encoder as wide as that of the other modality, where this is
    not compared: a profile and the step of a training depend on the width.
    """
    if len(kept) > 1:
        return data
    used = np.flatnonzero(getattr(data, kept[0]).any(0))
    width = int(used[-1]) + 1 if len(used) else data.width
    narrow: dict[str, Any] = {name: rows[:, :width] for name, rows in data.vectors.items()}
    return replace(data, **narrow)


def _named(sets: Mapping[str, Features], column: str) -> bool:
    """True if every set names this column of its pairs itself."""
    texts = [text for features in sets.values() for text in features.embeddings.rows[column]]
    return all(texts) and (column == "split" or not any(_NUMBERED.fullmatch(t) for t in texts))


def _keys(features: Features, columns: list[str]) -> list[Key]:
    data: Any = features.embeddings
    names = [[PurePath(text).name for text in data.rows[column]] for column in columns]
    places = [[data.header.domains[d] for d in data.domain]]
    places += [[data.header.classes[c] for c in data.label]]
    return list(zip(*places, *names, strict=True))


def _require_same(first: str, wanted: list[Key], name: str, own: list[Key]) -> None:
    lacks, more = (
        list((Counter(a) - Counter(b)).elements()) for a, b in ((wanted, own), (own, wanted))
    )
    in_order = len({*wanted}) == len(wanted) or wanted == own
    if not lacks and not more and in_order:
        return
    a, b = printable(first), printable(name)
    if not lacks and not more:
        what = "their rows are in another order, and names that tell pairs apart are missing"
    else:
        there = [
            f"'{who}' lacks {len(some)} of the {len(all_)} of '{whose}', such as {_shown(some[0])}"
            for who, whose, some, all_ in ((b, a, lacks, wanted), (a, b, more, own))
            if some
        ]
        what = "; ".join(there)
    raise DataError(
        f"'{a}' and '{b}' do not hold the same pairs: {what}. Embed the same pairs with each"
        " encoder."
    )


def _shown(key: Key) -> str:
    return printable("/".join(filter(None, key)))
