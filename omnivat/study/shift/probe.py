"""A linear probe of one domain on every other: what it loses, and what a profile gives back."""

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.data.profile import channels_of, moved
from omnivat.kit.logistic import scaling, solve
from omnivat.kit.progress import OnStep, Step
from omnivat.kit.seeding import derive_seed
from omnivat.study.shift.measure import LEAST, Record, record
from omnivat.study.shift.reading import Features

FOLDS = 3  # of objects, for the accuracy at home
PROFILE = 20  # pictures of the target without labels; they are not tested
STRENGTH = 1.0  # C, the inverse of the penalty
MEASURES = ("home", "away", "away, with a profile")
VIEWS = {"vis": ("vis",), "tac": ("tac",), "both": ("vis", "tac")}
Array = NDArray[Any]


def probes(found: Features, on_step: OnStep) -> list[Record]:
    """Return accuracies of logistic probes: at home, in each other domain, and there with a profile.

    A probe learns all pairs of one domain. "home" is its accuracy on held-out objects of that
    domain. With a profile, the target's channels get the source's mean and variance first, from
    PROFILE pairs without labels. The rest is tested in both cases.
    """
    data, objects = found.embeddings, found.objects
    places = {name: found.members(name) for name in found.domains}
    kinds = {name: len(np.unique(data.label[own])) for name, own in places.items()}
    names = [n for n, own in places.items() if len(own) >= LEAST and kinds[n] > 1]
    views = {n: v for n, v in VIEWS.items() if set(v) <= set(found.modalities)}
    if not found.labelled or not names:
        return []
    tested = {}  # rows of a domain's profile, and the others; a small domain gives half at most
    for name in names:
        mixed = np.random.default_rng(derive_seed(0, "profile", name)).permutation(places[name])
        tested[name] = [np.sort(part) for part in np.split(mixed, [min(PROFILE, len(mixed) // 2)])]
    records = []
    for done, (view, source) in enumerate((v, s) for v in views for s in names):
        raw = [np.array(getattr(data, name), np.float32) for name in views[view]]
        own = places[source]
        fitted = fitted_probe(joined([rows[own] for rows in raw]), data.label[own])
        records.append(record("probe", "home", _home(raw, data.label, own, objects), view, source, source, n=len(own)))
        for target in (name for name in names if name != source):
            profile, rest = tested[target]
            kept = rest[np.isin(data.label[rest], np.unique(data.label[own]))]
            if not len(kept):
                continue
            plain = [rows[kept] for rows in raw]
            known = [moved(rows[kept], channels_of(rows[profile]), channels_of(rows[own])) for rows in raw]
            for measure, rows in zip(MEASURES[1:], (plain, known), strict=True):
                right = float((fitted(joined(rows)) == data.label[kept]).mean())
                records.append(record("probe", measure, right, view, source, target, n=len(kept)))
        on_step(Step(done=done + 1, total=len(views) * len(names), text=f"probe of {source}, {view}"))
    return records + [line for view in views for line in _means(records, view, names)]


def joined(rows: list[Array]) -> torch.Tensor:
    """Return rows of unit length for each modality, side by side, as doubles."""
    each = [torch.nn.functional.normalize(torch.from_numpy(part).double(), dim=-1) for part in rows]
    return torch.cat(each, dim=-1)


def fitted_probe(rows: torch.Tensor, labels: Array) -> Any:
    """Return a function rows -> predicted labels."""
    classes, own = np.unique(labels, return_inverse=True)
    scale = scaling(rows, "unit")
    weight, bias = solve(scale(rows), torch.from_numpy(own), len(classes), STRENGTH)
    return lambda some: classes[(scale(some) @ weight.T + bias).argmax(1).numpy()]


def _home(raw: list[Array], label: Array, own: Array, objects: Array) -> float:
    """Return the accuracy on held-out objects; NaN with fewer objects than folds."""
    kinds = np.unique(objects[own])
    if len(kinds) < FOLDS:
        return float("nan")
    fold = np.argsort(np.random.default_rng(derive_seed(0, "home")).permutation(len(kinds))) % FOLDS
    part = fold[np.searchsorted(kinds, objects[own])]
    right = []
    for k in range(FOLDS):
        train, test = own[part != k], own[part == k]
        if len(np.unique(label[train])) > 1:
            fitted = fitted_probe(joined([rows[train] for rows in raw]), label[train])
            right.append(fitted(joined([rows[test] for rows in raw])) == label[test])
    return float(np.concatenate(right).mean()) if right else float("nan")


def _means(records: list[Record], view: str, names: list[str]) -> list[Record]:
    """Return the means over sources and targets; domains are drawn again for the intervals."""
    random = np.random.default_rng(derive_seed(0, "domains"))
    drawn = random.integers(len(names), size=(1000, len(names)))
    found, tables = [], {}
    for measure in MEASURES:
        tables[measure] = np.full((len(names), len(names)), np.nan)
        for one in records:
            if one["measure"] == measure and one["modality"] == view:
                tables[measure][names.index(one["from"]), names.index(one["to"])] = one["value"]
    home = np.repeat(np.diag(tables["home"])[:, None], len(names), 1)
    tables["loss: home less away"] = home - tables["away"]
    tables["gain of the profile"] = tables["away, with a profile"] - tables["away"]
    for measure, table in tables.items():
        if np.isnan(table).all():
            continue
        low, high, home_alone = None, None, measure == "home"
        if len(names) > 2:
            means = [table[d, d] if home_alone else table[np.ix_(d, d)] for d in drawn if len(set(d)) > 1]
            known = [np.nanmean(m) for m in means if not np.isnan(m).all()]
            low, high = np.nanquantile(known, [0.025, 0.975]).tolist()
        what = "domains" if home_alone else "pairs of domains"
        note = f"mean, {int((~np.isnan(table)).sum())} {what}"
        found.append(record("probe", measure, float(np.nanmean(table)), view, low=low, high=high, note=note))
    return found
