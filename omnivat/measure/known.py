"""One measurement: what a head reads right in domains that it has not met, by what is known of
them.

Known pairs are drawn and left out of the test; results are averaged over draws. `measured` gives
one figure with its interval, `evaluate` every reading in each domain:

    from omnivat.measure.rungs import labels, pairs

    measured(head, embeddings)                      # nothing is known
    measured(head, embeddings, pairs(5), draws=10)  # five pairs without labels: a profile
    evaluate(head, embeddings, labels(3))           # three labelled pairs of each class: taught

Two things that one may know are no `Known`. The number of source sensors is a fact of the head:
train heads of other sources and measure each. A picture of the sensor at rest changes pictures
before they are embedded: embed them with and without it, and measure both sets.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.data.embeddings import Embeddings
from omnivat.data.profile import drawn_profiles, profile_of, profiled
from omnivat.head.checkpoint import Head
from omnivat.head.teach import Lesson, taught
from omnivat.kit.errors import DataError
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.seeding import derive_seed
from omnivat.kit.stages import IMAGES
from omnivat.measure.gaps.confusion import confusion
from omnivat.measure.predictions import inputs_of, label_map, predicted_probabilities, scores
from omnivat.measure.rungs import NOTHING, Known
from omnivat.measure.unseen import counted, interval

DRAWS = 10
Array = NDArray[Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """The pairs of one domain that are left to predict, after the known ones were drawn."""

    domain: str
    head: Head  # which predicts them
    embeddings: Embeddings  # moved by the targets' profiles
    rows: NDArray[np.int64]  # (n,) of these embeddings
    places: NDArray[np.int64]  # (n,) of the whole set
    known_pairs: int = 0  # of the domain, drawn and left out

    def predicted(
        self, classes: Sequence[str], *, order: float | None = None
    ) -> tuple[NDArray[np.bool_], Tensor, dict[str, Tensor]]:
        """Return which rows are of one of `classes`, their labels, and predictions by reading.

        Labels and predictions are indices among the classes of the part's head.
        """
        names = self.embeddings.header.classes
        keep = label_map(classes, names)[self.embeddings.label[self.rows]] >= 0
        rows = self.rows[keep]
        truth = label_map(self.head.settings.classes, names)[self.embeddings.label[rows]]
        probabilities = (
            predicted_probabilities(
                self.head.model,
                self.embeddings,
                order=order,
                modalities=inputs_of(self.head),
                rows=rows,
            )
            if len(rows)
            else {}
        )
        named = {name: values.argmax(-1) for name, values in probabilities.items()}
        return keep, torch.from_numpy(truth), named


def parts(
    head: Head, embeddings: Embeddings, known: Known = NOTHING, *, seed: int = 0
) -> Iterator[Part]:
    """Draw the known pairs of each target; yield the rest of each domain, test pairs alone.

    The source stays as it is. Raises DataError for a negative number of pairs, or a head without
    its source's profile where pairs without labels are known.

    >>> from omnivat import default_embeddings, default_head, load_embeddings, load_head
    >>> from omnivat.measure.rungs import pairs
    >>> head, embeddings = load_head(default_head()), load_embeddings(default_embeddings())
    >>> [part.known_pairs for part in parts(head, embeddings, pairs(5))][:3]
    [0, 5, 5]
    """
    names = embeddings.header.domains
    if known.labels:
        for name in names:
            yield _taught(head, embeddings, name, known.labels, seed)
        return
    profiles, drawn = drawn_profiles(embeddings, head.source, known.pairs, seed=seed)
    rest = np.setdiff1d(np.arange(len(embeddings)), drawn)
    near = embeddings.select(rest) if len(drawn) else embeddings
    if profiles:
        near = profiled(near, profiles, head.source_profile)
    for name in names:
        rows = near.rows_of(name, split="test")
        count = profiles[name].counts["vis"] if name in profiles else 0
        yield Part(
            domain=name, head=head, embeddings=near, rows=rows, places=rest[rows], known_pairs=count
        )


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
    >>> from omnivat.measure.rungs import labels, pairs
    >>> head, embeddings = load_head(default_head()), load_embeddings(default_embeddings())
    >>> for known in (NOTHING, pairs(20), labels(3)):
    ...     found = measured(head, embeddings, known, draws=1)
    ...     print(found["known"], found["low"] < found["accuracy"] < found["high"])
    nothing: pictures as they come True
    20 pairs without labels True
    3 labelled pairs of each class True
    """
    head.require_embeddings(embeddings)
    right = np.stack(
        [_right(head, embeddings, known, one, home) for one in known.seeds(seed, draws)]
    )
    if np.isnan(right).all():
        where = f"of '{head.source}', which needs a split" if home else "of any other domain"
        raise DataError(
            f"No test pair {where} is of a class that the head learned:"
            f" {', '.join(head.settings.classes[:5])}{' …' * (len(head.settings.classes) > 5)}."
        )
    return {"rung": known.name, "known": known.words} | record(
        right, embeddings.domain, embeddings.header.domains
    )


def evaluate(
    head: Head,
    embeddings: Embeddings,
    known: Known = NOTHING,
    *,
    draws: int = DRAWS,
    seed: int = 0,
    order: float | None = None,
    on_step: OnStep = ignore,
) -> list[dict[str, Any]]:
    """Return one record for each domain: counts, ACC and macro-F1 of every reading.

    known  drawn from each target's training pairs, `draws` times with seeds `seed`, `seed` + 1, ...
           Scores are means over draws, "draws" the ACC of each; counts are those of the first
    order  quarter turns; None: the learned one

    If the data have a split, only the test part counts. "trained_on" is true when evaluated on
    training pairs. Pairs of classes that the head lacks are left out and counted. F1 averages the
    classes present in the domain; the "union" variant also averages classes that were only
    predicted. Raises DataError if the embeddings are from another encoder.

    >>> from omnivat import default_embeddings, default_head, load_embeddings, load_head
    >>> head, pairs = load_head(default_head()), load_embeddings(default_embeddings())
    >>> home, away = evaluate(head, pairs)[:2]
    >>> home["domain"], home["is_source"], away["domain"]
    ('TAG-sim', True, 'OF Real-sim')
    >>> home["scores"]["fused"]["accuracy"] > away["scores"]["fused"]["accuracy"]
    True
    """
    head.require_embeddings(embeddings)
    sizes = np.bincount(embeddings.domain, minlength=len(embeddings.header.domains)).cumsum()
    records: dict[str, list[dict[str, Any]]] = {name: [] for name in embeddings.header.domains}
    for one in known.seeds(seed, draws):
        drawn = parts(head, embeddings, known, seed=one)
        for part, done in zip(drawn, sizes.tolist(), strict=True):
            if part.known_pairs or not records[part.domain]:  # without draws, all are alike
                records[part.domain].append(_record(head, part, order))
            on_step(Step(done=done, total=len(embeddings), text=part.domain))
    return [_averaged(of_draws) for of_draws in records.values()]


def _record(head: Head, part: Part, order: float | None) -> dict[str, Any]:
    keep, truth, named = part.predicted(head.settings.classes, order=order)
    classes, split = part.head.settings.classes, part.embeddings.rows["split"]
    source = part.domain == head.source
    record = {
        "domain": part.domain,
        "is_source": source,
        "trained_on": source and not any(split[row] for row in part.rows),
        "order": head.model.order if order is None else order,
        "pairs": int(keep.sum()),
        "left_out": int((~keep).sum()),
        "known_pairs": part.known_pairs,
        "scores": {name: scores(truth, values) for name, values in named.items()},
    }
    if named:
        record["classes"] = list(classes)
        record["confusion"] = confusion(truth, named["fused"], len(classes)).tolist()
    return record


def _averaged(draws: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the records of one domain as one."""
    first, *others = draws
    if not others:
        return first
    tested = [record["scores"] for record in draws if record["scores"]]
    means = {
        reading: {m: sum(scores[reading][m] for scores in tested) / len(tested) for m in values}
        for reading, values in first["scores"].items()
    }
    return first | {"scores": means, "draws": [s["fused"]["accuracy"] for s in tested]}


def target_scores(records: Iterable[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Return the fused scores of the records of `evaluate` whose domain is not the source."""
    return [r["scores"]["fused"] for r in records if not r["is_source"] and r["scores"]]


def target_mean(scores: Iterable[Mapping[str, Any]], metric: str = "accuracy") -> float:
    """Return the unweighted mean of a metric over targets, one mapping each; NaN without
    targets.
    """
    values = [found[metric] for found in scores]
    return sum(values) / len(values) if values else float("nan")


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


def _right(head: Head, embeddings: Embeddings, known: Known, seed: int, home: bool) -> Array:
    """Return (N,) 1 for a right prediction, 0 for a wrong one, NaN for a pair that is not
    tested.
    """
    tested = counted(embeddings, head.source)
    right = np.full(len(embeddings), np.nan)
    for part in parts(head, embeddings, known, seed=seed):
        if (part.domain == head.source) == home and tested[part.places].any():
            keep, truth, named = part.predicted(head.settings.classes)
            if keep.any():
                right[part.places[keep]] = named["fused"] == truth
    return right


def _taught(head: Head, embeddings: Embeddings, name: str, count: int, seed: int) -> Part:
    """Return a domain without `count` labelled pairs of each class, and a head that they taught;
    the source as it is.
    """
    pool = embeddings.rows_of(name, split="train")
    pool = pool[embeddings.label[pool] >= 0]
    test = embeddings.rows_of(name, split="test")
    if name == head.source or not len(pool):
        return Part(domain=name, head=head, embeddings=embeddings, rows=test, places=test)
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
    rest = np.setdiff1d(test, some)
    return Part(
        domain=name,
        head=taught(head, lessons),
        embeddings=near,
        rows=rest,
        places=rest,
        known_pairs=len(some),
    )
