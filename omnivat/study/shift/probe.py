"""Linear maps of one domain on every other: what they lose, and what a profile gives back."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.data.profile import channels_of, moved
from omnivat.head.linear_maps import fit_maps
from omnivat.kit.progress import OnStep, Step
from omnivat.kit.seeding import derive_seed
from omnivat.study.shift.measure import LEAST, Record, record
from omnivat.study.shift.reading import Features

FOLDS = 3  # of objects, for the accuracy at home
PROFILE = 20  # pictures of the target without labels; they are not tested
MEASURES = ("home", "away", "away, with a profile")
Array = NDArray[Any]


Raw = Mapping[str, Array]  # rows (N, W) by modality


def probes(features: Features, on_step: OnStep) -> list[Record]:
    """Return accuracies of linear maps: at home, in each other domain, and there with a profile.

    The maps learn all pairs of one domain. "home" is their accuracy on held-out objects of that
    domain. With a profile, the target's channels get the source's mean and variance first, from
    PROFILE pairs without labels. The rest is tested in both cases.
    """
    label, objects = features.embeddings.label, features.objects
    places = {name: features.members(name) for name in features.domains}
    names = [n for n, own in places.items() if len(own) >= LEAST and len(np.unique(label[own])) > 1]
    if not features.labelled or not names:
        return []
    records = []
    for done, source in enumerate(names):
        home = places[source]
        raw = raw_of(features, home)
        fitted = fitted_probe(raw, label[home])
        for view, right in _home(raw, label[home], objects[home]).items():
            records.append(record("probe", "home", right, view, source, source, n=len(home)))
        for target in (name for name in names if name != source):
            # a small domain gives half of its pairs to the profile at most
            random = np.random.default_rng(derive_seed(0, "profile", target))
            mixed = random.permutation(places[target])
            count = min(PROFILE, len(mixed) // 2)
            pictures, rest = raw_of(features, np.sort(mixed[:count])), np.sort(mixed[count:])
            kept = rest[np.isin(label[rest], label[home])]
            if not len(kept):
                continue
            plain = raw_of(features, kept)
            known = {
                name: moved(rows, channels_of(pictures[name]), channels_of(raw[name]))
                for name, rows in plain.items()
            }
            for measure, rows in zip(MEASURES[1:], (plain, known), strict=True):
                for view, answers in fitted(rows).items():
                    right = float((answers == label[kept]).mean())
                    place = view, source, target
                    records.append(record("probe", measure, right, *place, n=len(kept)))
        on_step(Step(done=done + 1, total=len(names), text=f"probe of {source}"))
    return records + [line for view in features.views for line in _means(records, view, names)]


def raw_of(features: Features, rows: NDArray[np.int64]) -> dict[str, Array]:
    """Return embeddings (N, W) of some pairs by modality, as floats of 32 bits."""
    return {
        n: np.array(getattr(features.embeddings, n)[rows], np.float32) for n in features.modalities
    }


def fitted_probe(raw: Raw, labels: Array) -> Callable[[Raw], dict[str, Array]]:
    """Return a function of raw rows: predicted labels by reading, "vis", "tac" and "both".

    The yardstick of `try` and `report`: linear maps without training noise.
    """
    classes, index = np.unique(labels, return_inverse=True)
    tensors = {name: torch.from_numpy(rows) for name, rows in raw.items()}
    fitted = fit_maps(tensors, torch.from_numpy(index), len(classes))

    def answers(some: Raw) -> dict[str, Array]:
        shares = fitted({name: torch.from_numpy(rows) for name, rows in some.items()})
        named = {name: shares[name] for name in raw}
        if len(raw) > 1:
            named["both"] = shares["fused"]
        return {view: classes[values.argmax(-1).numpy()] for view, values in named.items()}

    return answers


def _home(raw: Raw, label: Array, objects: Array) -> dict[str, float]:
    """Return accuracies on held-out objects; NaN with fewer objects than folds."""
    kinds = np.unique(objects)
    mixed = np.random.default_rng(derive_seed(0, "home")).permutation(len(kinds))
    part = (np.argsort(mixed) % FOLDS)[np.searchsorted(kinds, objects)]
    views = [*raw, *["both"] * (len(raw) > 1)]
    right: dict[str, list[Array]] = {view: [] for view in views}
    for k in range(FOLDS if len(kinds) >= FOLDS else 0):
        train, test = part != k, part == k
        if len(np.unique(label[train])) > 1:
            fitted = fitted_probe({n: rows[train] for n, rows in raw.items()}, label[train])
            for view, answers in fitted({n: rows[test] for n, rows in raw.items()}).items():
                right[view].append(answers == label[test])
    return {
        view: float(np.concatenate(values).mean()) if values else float("nan")
        for view, values in right.items()
    }


def _means(records: list[Record], view: str, names: list[str]) -> list[Record]:
    """Return the means over sources and targets; domains are drawn again for the intervals."""
    random = np.random.default_rng(derive_seed(0, "domains"))
    drawn = random.integers(len(names), size=(1000, len(names)))
    tables = {measure: np.full((len(names), len(names)), np.nan) for measure in MEASURES}
    for one in records:
        if one["modality"] == view:
            place = names.index(one["from"]), names.index(one["to"])
            tables[one["measure"]][place] = one["value"]
    home, away, known = tables.values()
    tables["loss: home less away"] = np.diag(home)[:, None] - away
    tables["gain of the profile"] = known - away
    means = []
    for measure, table in tables.items():
        if np.isnan(table).all():
            continue
        low = high = None
        if len(names) > 2:
            blocks = [
                table[d, d] if measure == "home" else table[np.ix_(d, d)]
                for d in drawn
                if len(set(d)) > 1
            ]
            values = [np.nanmean(some) for some in blocks if not np.isnan(some).all()]
            low, high = np.nanquantile(values, [0.025, 0.975]).tolist()
        count = int((~np.isnan(table)).sum())
        note = f"mean, {count} {'domains' if measure == 'home' else 'pairs of domains'}"
        mean = float(np.nanmean(table))
        means.append(record("probe", measure, mean, view, low=low, high=high, note=note))
    return means
