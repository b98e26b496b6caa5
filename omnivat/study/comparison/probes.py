"""Accuracy of linear maps on each set's embeddings: trained on one domain, tested on all.

The maps are those of `omnivat report`. Every set meets the same training pairs, test pairs and
known pairs, so its values can be compared pair by pair.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings
from omnivat.data.numbers import are_numbers
from omnivat.data.profile import Profile, profile_of
from omnivat.head.linear_maps import standard_rows
from omnivat.head.predict_set import label_map, predicted
from omnivat.head.teach import Lesson
from omnivat.kit.errors import DataError, printable
from omnivat.kit.seeding import derive_seed
from omnivat.kit.tables import suggestion
from omnivat.measure.known import few, parts
from omnivat.measure.readers import Reader
from omnivat.measure.rungs import NOTHING, Known, labels
from omnivat.study.comparison.ridge import Map, folds_of, ridge, ridge_chosen
from omnivat.study.shift.measure import LEAST
from omnivat.study.shift.probe import maps_of
from omnivat.study.shift.reading import Features

PENALTY, WEIGHT = 1.0, 20  # of the ridge that labels teach; a class's labels count as WEIGHT pairs
FEW, MORE, LABELS = 5, 20, 5
Array = NDArray[Any]
OnSource = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Column:
    """A column: what is measured, and of which pairs."""

    id: str
    title: str
    home: bool = False
    known: Callable[[Embeddings, str], Known] | None = None  # None: nothing


COLUMNS = (
    Column("home", "home", home=True),
    Column("away", "away, as it comes"),
    Column("away5", "5 pictures", known=partial(few, most=FEW)),
    Column("away20", "20 pictures", known=partial(few, most=MORE)),
    Column("labels5", "5 labels a class", known=lambda *_: labels(LABELS)),
)
OF_NUMBERS = tuple(column for column in COLUMNS if column.id != "labels5")


def sources_of(features: Features, values: Array | None = None) -> list[str]:
    """Return the domains that can be learned: of two classes, or of differing numbers."""
    data = features.embeddings
    given = data.label if values is None else values
    own = {n: given[features.members(n)] for n in features.domains}
    if values is None:
        own = {n: some[data.labelled[features.members(n)]] for n, some in own.items()}
    else:
        own = {n: some[~np.isnan(some)] for n, some in own.items()}
    return [n for n, some in own.items() if len(some) >= LEAST and len(np.unique(some)) > 1]


def rights(
    features: Features, sources: Sequence[str], *, draws: int, seed: int, on_source: OnSource
) -> dict[str, Array]:
    """Return by column the share of draws (S, N) in which a pair is read right by the maps of each
    source; NaN for a pair that is not tested.
    """
    data = features.embeddings
    made = {c.id: np.full((len(sources), len(data)), np.nan) for c in COLUMNS if _possible(c, data)}
    for s, source in enumerate(sources):
        rows = _learned(data, source, data.labelled)
        reader = _taught_maps(features, source, rows)
        learned = np.isin(data.label, data.label[rows]) & data.labelled
        for column in COLUMNS:
            if column.id not in made:
                continue
            if column.home:
                made[column.id][s] = _home(features, source, reader)
                continue
            known = column.known(data, source) if column.known else NOTHING
            seeds = known.seeds(seed, draws)
            each = np.stack([_away(reader, data, known, draw) for draw in seeds])
            right = np.where(each < 0, np.nan, each == data.label)
            made[column.id][s] = np.where(learned, _mean(right), np.nan)
        on_source(source)
    return made


def errors(
    features: Features,
    sources: Sequence[str],
    values: Array,
    *,
    draws: int,
    seed: int,
    on_source: OnSource,
) -> dict[str, Array]:
    """Return by column the errors (S, N) of ridge probes of numbers: predicted less true, and with
    known pictures their mean size; NaN for a pair that is not tested.
    """
    data, there = features.embeddings, ~np.isnan(values)
    made = {c.id: np.full((2, len(sources), len(data)), np.nan) for c in OF_NUMBERS}
    for s, source in enumerate(sources):
        rows = _learned(data, source, there)
        reader, tested = _of_numbers(features, source, rows, values), there
        for column in OF_NUMBERS:
            if column.home:
                each = _home_numbers(features, source, reader, values)[None]
            else:
                known = column.known(data, source) if column.known else NOTHING
                seeds = known.seeds(seed, draws)
                each = np.stack([_away(reader, data, known, draw, numbers=True) for draw in seeds])
            off = np.where(tested, each - values, np.nan)
            made[column.id][:, s] = _mean(off**2), _mean(abs(off))
        on_source(source)
    return made


def numbers_in(features: Features, column: str) -> Array:
    """Return the numbers (N,) of a column; NaN where a pair has none.

    Raises DataError for a set without that column, and for a text that is no number.
    """
    rows = features.embeddings.rows
    own = {name: texts for name, texts in rows.items() if are_numbers(texts)}
    if column not in rows:
        there = f"has the numbers {', '.join(own)}" if own else "has no column of numbers"
        raise DataError(
            f"The set has no column '{printable(column)}'; it {there}.{suggestion(column, own)}"
            " Numbers come from a column of the table that `embed` or `import` reads."
        )
    if column not in own:
        raise DataError(f"The column '{printable(column)}' does not hold numbers; name another.")
    return np.array([float(text) if text.strip() else np.nan for text in rows[column]])


def _possible(column: Column, data: Embeddings) -> bool:
    """True if something is left to test after the known pairs."""
    if column.id != "labels5" or any(data.rows["split"]):
        return True
    counts = np.zeros((len(data.header.domains), len(data.header.classes)), int)
    np.add.at(counts, (data.domain, data.label), 1)
    return bool((counts.max(1)[counts.any(1)] > LABELS).all())


def _mean(draws: Array) -> Array:
    made = ~np.isnan(draws)
    sums = np.where(made, draws, 0).sum(0)
    return np.where(made.any(0), sums / np.maximum(made.sum(0), 1), np.nan)


def _learned(data: Embeddings, source: str, usable: Array) -> Array:
    rows = data.rows_of(source, split="train")
    return rows[usable[rows]]


def _away(
    reader: Reader, data: Embeddings, known: Known, seed: int, *, numbers: bool = False
) -> Array:
    """Return what is predicted of each pair (N,) of other domains; -1 or NaN: not tested."""
    said = np.full(len(data), np.nan if numbers else -1)
    for part in parts(reader, data, known, seed=seed):
        if part.domain == reader.source or not len(part.rows):
            continue
        if numbers:
            said[part.rows] = part.reader.predict(part.embeddings, rows=part.rows)["fused"][:, 0]
        else:
            names = data.header.classes
            said[part.rows] = part.reader.answers(part.embeddings, part.rows, names)["fused"]
    return said


def _home(features: Features, source: str, reader: Reader) -> Array:
    """Return 1 for each pair (N,) of a source's test part, or of left-out objects, that is read
    right.
    """
    data = features.embeddings
    right = np.full(len(data), np.nan)
    for fit, out in _folds(data, source, data.labelled):
        learned = _learned(data, source, data.labelled) if fit is None else fit
        if len(np.unique(data.label[learned])) < 2:
            continue
        its = maps_of(features, source, fit) if fit is not None else reader
        out = out[np.isin(data.label[out], data.label[learned])]
        if len(out):
            said = its.answers(data, out, data.header.classes)["fused"]
            right[out] = said == data.label[out]
    return right


def _home_numbers(features: Features, source: str, reader: Reader, values: Array) -> Array:
    data = features.embeddings
    said = np.full(len(data), np.nan)
    for fit, out in _folds(data, source, ~np.isnan(values)):
        its = _of_numbers(features, source, fit, values) if fit is not None else reader
        said[out] = its.predict(data, rows=out)["fused"][:, 0]
    return said


def _folds(data: Embeddings, source: str, usable: Array) -> Iterator[tuple[Array | None, Array]]:
    """Yield what is learned (None: the training part) and what is tested of a source."""
    rows = data.rows_of(source)
    rows = rows[usable[rows]]
    if any(data.rows["split"][row] for row in rows):
        test = data.rows_of(source, split="test")
        yield None, test[usable[test]]
        return
    fold = folds_of(data.objects[rows], derive_seed(0, "home"))
    for k in np.unique(fold) if fold.any() else ():
        yield rows[fold != k], rows[fold == k]


def _standard(raw: Mapping[str, torch.Tensor], profile: Profile) -> Array:
    rows = [standard_rows(raw[n], own).numpy() for n, own in profile.channels.items()]
    joined: Array = np.concatenate(rows, 1).astype(np.float64)
    joined /= np.maximum(np.linalg.norm(joined, axis=1, keepdims=True), 1e-12)
    return joined


def _raw(data: Embeddings, rows: Array, names: Sequence[str]) -> dict[str, torch.Tensor]:
    return {n: torch.from_numpy(np.array(getattr(data, n)[rows], np.float32)) for n in names}


def _taught_maps(features: Features, source: str, rows: Array) -> Reader:
    """Return linear maps that labels teach: a ridge regression of the source's and their pairs."""
    data, names = features.embeddings, features.modalities
    reader = maps_of(features, source, rows)
    profile, classes = reader.profile(), data.header.classes
    own, own_labels = _standard(_raw(data, rows, names), profile), data.label[rows]

    def taught(lessons: Sequence[Lesson]) -> Reader:
        raw = {n: torch.cat([getattr(lesson, n) for lesson in lessons]) for n in names}
        some = label_map(classes, tuple(lesson.label for lesson in lessons))
        every = np.concatenate((own_labels, some))
        weights = np.ones(len(every))
        weights[len(own) :] = WEIGHT / np.bincount(some).max()
        hot = np.eye(len(classes))[every]
        read = ridge(np.concatenate((own, _standard(raw, profile))), hot, PENALTY, weights)
        there = np.where(hot.any(0), 0.0, -np.inf)

        def scores(given: Mapping[str, torch.Tensor]) -> dict[str, torch.Tensor]:
            found = torch.from_numpy(10 * read(_standard(given, profile)) + there)
            return {"fused": found.softmax(-1)}

        return replace(
            reader, classes=classes, predict=partial(predicted, scores, modalities=names)
        )

    return replace(reader, taught=taught)


def _of_numbers(features: Features, source: str, rows: Array, values: Array) -> Reader:
    """Return a ridge regression of numbers, trained on pairs of one domain.

    rows    (n,) the training pairs
    values  (N,) the number of each pair of the set
    """
    data, names = features.embeddings, features.modalities
    profile = profile_of(data, rows, domain=source, modalities=names)
    own = _standard(_raw(data, rows, names), profile)
    read: Map = ridge_chosen(own, values[rows][:, None], data.objects[rows])

    def scores(given: Mapping[str, torch.Tensor]) -> dict[str, torch.Tensor]:
        return {"fused": torch.from_numpy(read(_standard(given, profile)))}

    return Reader(
        classes=(),
        source=source,
        predict=partial(predicted, scores, modalities=names),
        profile=lambda: profile,
    )
