"""Try a set of pairs: a head that suits their number, and figures on objects that it did not
see.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.encoders.lang.bank import DEFAULT_BANK, load_bank
from omnivat.head.checkpoint import Head
from omnivat.head.head import parameter_count
from omnivat.kit.errors import DataError, printable
from omnivat.kit.progress import OnStep, ignore
from omnivat.kit.seeding import derive_seed
from omnivat.measure.gaps.confusion import balance, confusion
from omnivat.measure.known import few, measured, scored
from omnivat.measure.readers import Reader, of_head
from omnivat.measure.shares import record, shown
from omnivat.study.advice import PROBE, WORDS, Record, conclusion, percent, probe_of, sentence
from omnivat.study.shift.probe import maps_of
from omnivat.study.shift.reading import READINGS, Features
from omnivat.training import TrainingPlan, TrainSettings, Watch, plan_training, trained_head
from omnivat.training.training import steps_of

EPOCHS = 40  # of every training
FOLDS, FEW = 5, 200  # up to FEW pairs; with more, 3
NO_CLASSES = (
    "the pairs have no classes, or all have the same one. Gaps, retrieval and maps need none:"
    " `python -m omnivat report` measures them."
)
Rows = NDArray[np.int64]
Labels = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """A head (None: `lines` say why), figures as records, and both in sentences."""

    head: Head | None
    lines: list[str]
    records: list[Record] = field(default_factory=list)


def try_pairs(
    features: Features, *, source: str = "", seed: int = 0, on_step: OnStep = ignore
) -> Trial:
    """Train on one domain and measure at home, with whole objects left out, and in every other
    domain.

    source  "": the domain with the most pairs among those with two classes or more

    Raises DataError for a source without two classes.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from omnivat import read_features
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "mine.npz"
    ...     np.savez(file, tac=np.eye(4), domain=["A", "A", "B", "B"])
    ...     trial = try_pairs(read_features(file))
    >>> trial.head, trial.lines[0][:47]  # with classes: a head, and what it reads right
    (None, 'No head was trained: the pairs have no classes,')
    """
    data = features.embeddings.unsplit
    features = replace(features, embeddings=data)
    able = data.learnable
    if source and source not in able:
        raise DataError(
            f"'{printable(source)}' cannot train a head: it needs pairs of two classes. Choose "
            f"{' or '.join(able) or 'a set with labels'}."
        )
    if not features.labelled or not able:
        why = "no single domain has pairs of two classes." if features.labelled else NO_CLASSES
        return Trial(head=None, lines=[f"No head was trained: {why}"])
    source = source or max(able, key=lambda name: len(features.members(name)))
    plan, objects = _plan(features, source, seed), data.objects
    own = plan.rows
    folds, alone = _folds(data.label[own], objects[own], seed)
    each = plan.training.epochs * steps_of(len(plan.rows), plan.training)
    watch, whole = Watch(on_step=on_step), (len(folds) + 1) * each
    head = trained_head(plan, watch=watch.part(0, whole))
    names = [name for view in features.views for name in (view, probe_of(view))]
    said = {name: np.full(len(own), -1) for name in names}
    for k, out in enumerate(folds):
        fit, turn = replace(plan, rows=own[~out]), watch.part((k + 1) * each, whole)
        of_fold = of_head(trained_head(fit, calibrate=False, watch=turn))
        for name_of, reader in ((str, of_fold), (probe_of, maps_of(features, "", fit.rows))):
            answers = reader.answers(data, own[out], data.header.classes)
            for view in features.views:
                said[name_of(view)][out] = answers[READINGS[view]]
    head = scored(head, data)
    lines = [_about(plan, source)]
    records = []
    if folds:
        tested = np.any(folds, axis=0)
        predicted = {name: labels[tested] for name, labels in said.items()}
        labels = data.label[own][tested]
        records.append(_at_home(source, labels, objects[own][tested], predicted))
        lines.append(f"At home, objects that it did not see: {sentence(records[-1])}")
        lines += alone
    else:
        lines.append(
            f"At home there is no honest figure: every class of '{source}' has one object only, so "
            "none can be left out. Add a second object of each class."
        )
    targets = [name for name in features.domains if name != source]
    maps = maps_of(features, source, own)
    for name in targets:
        away, text = _in_target(features, head, maps, own, name, seed)
        records += [away] if away else []
        lines.append(text)
    if not targets:
        lines.append("There is one domain, so how this head fares on another sensor is not known.")
    if len(np.unique(objects)) == len(data) and len(data) > 2:
        lines.append(
            "No two pairs share an object's name, so each pair counts as an object. If several show"
            " one thing, name the objects: these figures are too good otherwise."
        )
    lines.append(conclusion(records, source))
    return Trial(head=head, lines=lines, records=records)


def _plan(features: Features, source: str, seed: int) -> TrainingPlan:
    """Return the plan of a head that suits the pairs: small, with noise and imitated sensors."""
    data, home = features.embeddings, features.members(source)
    batch = 16 if len(home) <= 500 else 64 if len(home) <= 2000 else 256
    learned = np.unique(data.label[home[data.labelled[home]]])
    classes = {data.header.classes[k] for k in learned}
    training = TrainSettings(
        epochs=EPOCHS,
        batch=batch,
        noise=4.0,
        shift=1.0,
        lang=classes <= set(load_bank(DEFAULT_BANK).classes),
        modalities="+".join(features.modalities),
    )
    return plan_training(data, source, head={"width": 64}, training=training, seed=seed)


def _folds(labels: Labels, objects: Rows, seed: int) -> tuple[list[NDArray[np.bool_]], list[str]]:
    """Return masks (N,) of left-out pairs, and a note on classes of one object, which stay in."""
    random = np.random.default_rng(derive_seed(seed, "folds"))
    most = FOLDS if len(labels) <= FEW else 3
    fold, alone = np.full(len(labels), -1), 0
    _, first = np.unique(objects, return_index=True)
    for label in np.unique(labels[first]):
        own = random.permutation(objects[first][labels[first] == label])
        if len(own) < 2:
            alone += 1
            continue
        start = int(random.integers(most))
        for k, name in enumerate(own):
            fold[objects == name] = (start + k) % most
    masks = [fold == k for k in range(most) if (fold == k).any()]
    masks = [out for out in masks if len(np.unique(labels[~out])) > 1]
    word = f"{alone} {'class has' if alone == 1 else 'classes have'}"
    left = f"{word} one object only: its pairs are trained on and not tested."
    return masks, [left] if alone and masks else []


def _at_home(domain: str, labels: Labels, objects: Rows, said: dict[str, Labels]) -> Record:
    """Return the record of pairs whose objects were left out, by the labels that were said."""
    place = np.zeros(len(labels), np.int64), (domain,), objects
    shares = {name: record((answers == labels)[None], *place) for name, answers in said.items()}
    truth, classes = torch.from_numpy(labels), int(max(map(np.max, (labels, *said.values())))) + 1
    counts = {
        name: confusion(truth, torch.from_numpy(answers), classes) for name, answers in said.items()
    }
    return _record(domain, labels, len(np.unique(objects)), shares, counts)


def _record(
    domain: str,
    labels: Labels,
    objects: int,
    shares: Mapping[str, Mapping[str, Any]],
    counts: Mapping[str, Any],
) -> Record:
    """Return the counts of tested pairs with `labels`, the share right of each reading with its
    interval, and the balanced accuracy of those with a confusion matrix in `counts`.
    """
    balances = {name: balance(counted) for name, counted in counts.items()}
    some = next(iter(balances.values()))
    return {
        "domain": domain,
        "pairs": len(labels),
        "objects": objects,
        "classes": len(np.unique(labels)),
        "always the largest class": some.always,
        "uneven": some.uneven,
        "balanced": {name: found.balanced for name, found in balances.items()},
        **{name: shown(share) for name, share in shares.items()},
    }


def _in_target(
    features: Features, head: Head, maps: Reader, home: Rows, name: str, seed: int
) -> tuple[Record | None, str]:
    """Return the record of a target domain, plain and with a profile of its pictures, and a
    sentence.
    """
    data, lead = features.embeddings, f"In '{printable(name)}'"
    rows = features.members(name)
    there, known = data.select(rows), rows[np.isin(data.label[rows], data.label[home])]
    if not len(known):
        return None, f"{lead}: no pair is of a class that the head learned."
    plain = next(domain for domain in head.metrics["domains"] if domain["domain"] == name)
    of_maps = measured(maps, there)
    shares = {view: plain["scores"][READINGS[view]] for view in features.views}
    shares |= {probe_of(view): of_maps["scores"][READINGS[view]] for view in features.views}
    main = next(view for view in WORDS if view in shares)
    of_maps = next(domain for domain in of_maps["domains"] if domain["domain"] == name)
    counts = {main: plain["confusion"], probe_of(main): of_maps["confusion"]}
    found = _record(name, data.label[known], plain["objects"], shares, counts)
    lit = data.header.lit_by.get(name)
    of = f"lamps from {lit} touches were" if lit else "nothing was"
    text = f"{lead}, of which {of} known: {sentence(found)}"
    try:
        pictures = few(there, head.source)
    except DataError as error:
        text += f" {error}"
    else:
        step, of_maps = (measured(reader, there, pictures, seed=seed) for reader in (head, maps))
        kept = {key: step[key] for key in ("accuracy", "low", "high", "draws")}
        found["profile"] = {"pictures": pictures.pairs, **kept, PROBE: shown(of_maps)}
        text += (
            f" With a profile of {pictures.pairs} of its pairs without labels, which are not"
            f" tested: {percent(step['accuracy'])}, {PROBE} {percent(of_maps['accuracy'])} (mean"
            f" of {len(step['draws'])} draws)."
        )
    shared = {data.rows["object"][k] for k in home} & {data.rows["object"][k] for k in known} - {""}
    if shared:
        text += (
            f" {len(shared)} of its objects have names of training objects: if they are the same"
            " things, only the sensor is new."
        )
    return found, text


def _about(plan: TrainingPlan, source: str) -> str:
    numbers, settings = parameter_count(plan.settings), plan.training
    without = f" ({plan.left_out} pairs without a class left out)" if plan.left_out else ""
    return (
        f"Trained on '{printable(source)}': {len(plan.rows)} pairs, {len(plan.settings.classes)}"
        f" classes{without}; a small head of {numbers:,} numbers (width {plan.settings.width},"
        f" noise {settings.noise:g}, shift {settings.shift:g}, {settings.epochs}"
        f" epochs{', with texts' if settings.lang else ''})."
    )
