"""Linear maps of one domain on every other: what they lose, and what a profile gives back."""

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.head.linear_maps import fit_maps
from omnivat.kit.progress import OnStep, Step
from omnivat.kit.seeding import derive_seed
from omnivat.measure.gaps.confusion import balance
from omnivat.measure.known import few, measured
from omnivat.measure.readers import Reader, of_maps
from omnivat.measure.rungs import NOTHING
from omnivat.study.shift.measure import LEAST, Record, record
from omnivat.study.shift.reading import READINGS, Features

FOLDS = 3  # of objects, for the accuracy at home
MEASURES = ("home", "away", "away, with a profile")
# beside them where classes are uneven
UNEVEN = (
    "home, balanced over classes",
    "away, balanced over classes",
    "away, always the largest class",
)
Array = NDArray[Any]


def probes(features: Features, on_step: OnStep) -> list[Record]:
    """Return accuracies of linear maps: at home, in each other domain, and there with a profile.

    The maps learn all pairs of one domain. "home" is their accuracy on held-out objects of that
    domain. With a profile, the target's channels get the source's mean and variance first, from a
    few pairs without labels, which are not tested: the mean of several draws. Where a tested
    domain has uneven classes, balanced accuracies and the share of its largest class follow.
    """
    data = features.embeddings.unsplit
    places = {name: features.members(name) for name in features.domains}
    names = [
        n for n, own in places.items() if len(own) >= LEAST and len(np.unique(data.label[own])) > 1
    ]
    if not features.labelled or not names:
        return []
    records = []
    for done, source in enumerate(names):
        home = places[source]
        for view, counts in _home(features, home).items():
            place, n = (view, source, source), len(home)
            right = float(counts.diagonal().sum() / counts.sum()) if counts.any() else float("nan")
            records.append(record("probe", "home", right, *place, n=n))
            if counts.any() and (own := balance(counts)).uneven:
                records.append(record("probe", UNEVEN[0], own.balanced, *place, n=n))
        maps = maps_of(features, source, home)
        for target in (name for name in names if name != source):
            there = data.select(places[target])
            for measure, known in zip(MEASURES[1:], (NOTHING, few(there, source)), strict=True):
                result = measured(maps, there, known)
                for view in features.views if result["pairs"] else ():
                    share = result["scores"][READINGS[view]]
                    ends = {"low": share["low"], "high": share["high"], "n": result["pairs"]}
                    place = view, source, target
                    records.append(record("probe", measure, share["accuracy"], *place, **ends))
                main = features.views[-1]
                counts = next(x["confusion"] for x in result["domains"] if x["domain"] == target)
                if known is NOTHING and result["pairs"] and (own := balance(counts)).uneven:
                    for name, value in zip(UNEVEN[1:], (own.balanced, own.always), strict=True):
                        place = main, source, target
                        records.append(record("probe", name, value, *place, n=result["pairs"]))
        on_step(Step(done=done + 1, total=len(names), text=f"probe of {source}"))
    return records + [line for view in features.views for line in _means(records, view, names)]


def maps_of(features: Features, source: str, rows: NDArray[np.int64]) -> Reader:
    """Return linear maps that learned some pairs of a source, without training noise: the
    yardstick of `try` and `report`.
    """
    data = features.embeddings
    present, labels = np.unique(data.label[rows], return_inverse=True)
    raw = {
        name: torch.from_numpy(np.array(getattr(data, name)[rows], np.float32))
        for name in features.modalities
    }
    fitted = fit_maps(raw, torch.from_numpy(labels), len(present))
    classes = tuple(data.header.classes[k] for k in present)
    return of_maps(fitted, data.header, source=source, classes=classes)


def _home(features: Features, home: NDArray[np.int64]) -> dict[str, Array]:
    """Return confusion matrices (K, K) of held-out objects; zeros with fewer objects than folds."""
    data = features.embeddings
    label, objects = data.label[home], data.objects[home]
    kinds = np.unique(objects)
    mixed = np.random.default_rng(derive_seed(0, "home")).permutation(len(kinds))
    part = (np.argsort(mixed) % FOLDS)[np.searchsorted(kinds, objects)]
    size = len(data.header.classes)
    counts = {view: np.zeros((size, size), np.int64) for view in features.views}
    for k in range(FOLDS if len(kinds) >= FOLDS else 0):
        train, test = part != k, part == k
        if len(np.unique(label[train])) > 1:
            maps = maps_of(features, "", home[train])
            said = maps.answers(data, home[test], data.header.classes)
            for view, table in counts.items():
                np.add.at(table, (label[test], said[READINGS[view]]), 1)
    return counts


def _means(records: list[Record], view: str, names: list[str]) -> list[Record]:
    """Return the means over sources and targets; domains are drawn again for the intervals."""
    random = np.random.default_rng(derive_seed(0, "domains"))
    drawn = random.integers(len(names), size=(1000, len(names)))
    nothing = np.full((len(names), len(names)), np.nan)
    tables = {measure: nothing.copy() for measure in (*MEASURES, *UNEVEN)}
    for row in records:
        if row["modality"] == view:
            place = names.index(row["from"]), names.index(row["to"])
            tables[row["measure"]][place] = row["value"]
    home, away, known = (tables[measure] for measure in MEASURES)
    tables["loss: home less away"] = np.diag(home)[:, None] - away
    tables["gain of the profile"] = known - away
    means = []
    for measure, table in tables.items():
        if np.isnan(table).all():
            continue
        low = high = None
        if len(names) > 2:
            blocks = [
                table[d, d] if measure.startswith("home") else table[np.ix_(d, d)]
                for d in drawn
                if len(set(d)) > 1
            ]
            values = [np.nanmean(some) for some in blocks if not np.isnan(some).all()]
            low, high = np.nanquantile(values, [0.025, 0.975]).tolist()
        count = int((~np.isnan(table)).sum())
        note = f"mean, {count} {'domains' if measure.startswith('home') else 'pairs of domains'}"
        mean = float(np.nanmean(table))
        means.append(record("probe", measure, mean, view, low=low, high=high, note=note))
    return means
