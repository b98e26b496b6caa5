"""Gaps and scores of a set as functions of the order: one curve a measure and stage."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.data.store import Embeddings
from omnivat.gaps.measures import ANSWER_MEASURES, STAGE_MEASURES, SUM_MEASURES, Facts
from omnivat.gaps.unit import unit
from omnivat.model.head import OmniVaT
from omnivat.progress import OnStep, Step, ignore
from omnivat.sweep.walk import CHUNK, STILL, AtOrder, coarse_first, require_known, walk

MEASURES = ("modality_gap", "domain_gap", "margin", "accuracy", "macro_f1")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sweep:
    """Curves over P orders for N pairs.

    orders         (P,) quarter turns, as asked for
    classes        the head's K classes, then classes of the set that it does not know
    label          (N,) index into `classes`
    probabilities  (P, N, K) float32, fused; (P, 0, K) when no answers were asked for
    curves         "measure/stage", "accuracy/all" and the like -> (P,) float64; NaN where a
                   value does not exist. docs/gaps.md lists the names
    """

    orders: NDArray[np.float64]
    classes: tuple[str, ...]
    label: NDArray[np.int64]
    probabilities: NDArray[np.float32]
    curves: dict[str, NDArray[np.float64]] = field(default_factory=dict)


def sweep(
    model: OmniVaT,
    embeddings: Embeddings,
    orders: Sequence[float],
    *,
    stages: Sequence[str] = ("f_hat",),
    measures: Sequence[str] = MEASURES,
    chunk: int = CHUNK,
    on_step: OnStep = ignore,
) -> Sweep:
    """Measure gaps and answers of a set at every order.

    orders    quarter turns, any real numbers; visited coarse first, returned as given
    stages    of `STAGES`; what is not asked for is not kept
    measures  of `STAGE_MEASURES` and `ANSWER_MEASURES`
    chunk     pairs that pass the head at once. Memory is one order's answers, the probabilities of
              all orders and, where a measure is not of `SUM_MEASURES`, one order's features

    Measures of the raw embedding and the raw DFrFT are computed once and hold for every order.
    Without answer measures and moving stages the head is asked for one order at most.
    Raises SettingsError for a stage, measure or order that cannot be.
    """
    require_known(measures, (*STAGE_MEASURES, *ANSWER_MEASURES), "measure")
    classes, facts = facts_of(embeddings, model.settings.classes, model.classifier.device)
    answers = [name for name in measures if name in ANSWER_MEASURES]
    result = Sweep(
        orders=np.array(orders, dtype=np.float64),
        classes=classes,
        label=facts.labels.cpu().numpy(),
        probabilities=np.zeros(
            (len(orders), len(embeddings) if answers else 0, len(model.settings.classes)),
            dtype=np.float32,
        ),
    )
    visits = coarse_first(len(orders))
    summed = all(name in SUM_MEASURES for name in measures if name in STAGE_MEASURES)
    walked = walk(
        model,
        embeddings,
        orders,
        stages=stages,
        answers=bool(answers),
        visits=visits,
        chunk=chunk,
        sums_for=facts if summed else None,
    )
    for done, found in enumerate(walked, start=1):
        for stage, name, value in measured(found, facts, measures):
            curve = result.curves.setdefault(name, np.full(len(orders), np.nan))
            curve[slice(None) if stage in STILL else found.index] = value
        if answers:
            result.probabilities[found.index] = found.probabilities["fused"].cpu().numpy()
        on_step(Step(done=done, total=len(visits), text=f"order {found.order:.2f}"))
    return result


def measured(
    found: AtOrder, facts: Facts, measures: Sequence[str]
) -> Iterator[tuple[str, str, float]]:
    """Give every curve's value at one order: stage ("" for answers), name of the curve, value."""
    for stage in (*found.features, *found.sums):
        for name, suffix, value in _of_stage(found, stage, facts, measures):
            variant, _, domain = suffix.partition("/")
            tail = f"/{domain}" if domain else ""
            yield stage, f"{name}{variant}/{stage}{tail}", float(value)
    for name in measures:
        if name in ANSWER_MEASURES and found.probabilities:
            for suffix, value in ANSWER_MEASURES[name](found.probabilities, facts):
                yield "", f"{name}{suffix}", float(value)


def _of_stage(
    found: AtOrder, stage: str, facts: Facts, measures: Sequence[str]
) -> Iterator[tuple[str, str, Tensor]]:
    """Give measure, suffix and value; the sums of a stage are taken once for all that need them."""
    features, sums = found.features.get(stage, {}), found.sums.get(stage)
    if sums is None and any(name in SUM_MEASURES for name in measures):
        sums = facts.sums()
        sums.add(features, facts.labels, facts.domains)
    whole = [name for name in measures if name in STAGE_MEASURES and name not in SUM_MEASURES]
    units = {name: unit(rows) for name, rows in features.items()} if whole else {}
    for name in measures:
        if name in whole:
            values = STAGE_MEASURES[name](units, facts)
        elif name in SUM_MEASURES and sums is not None:
            values = SUM_MEASURES[name](sums, facts)
        else:
            continue
        yield from ((name, suffix, value) for suffix, value in values)


def facts_of(
    embeddings: Embeddings, known: tuple[str, ...], device: torch.device | None = None
) -> tuple[tuple[str, ...], Facts]:
    """Return the classes, those `known` to the head first, and what holds at any order.

    A class that the head does not know keeps its name; its pairs count in gaps, not in scores.
    """
    header = embeddings.header
    classes = (*known, *(name for name in header.classes if name not in known))
    index = torch.tensor([classes.index(name) for name in header.classes], dtype=torch.long)
    labels = index[torch.from_numpy(np.array(embeddings.label))].to(device)
    return classes, Facts(
        labels=labels,
        class_names=classes,
        domains=torch.from_numpy(np.array(embeddings.domain)).to(device),
        domain_names=header.domains,
        scored=labels < len(known),
    )
