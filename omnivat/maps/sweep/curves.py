"""Gaps and scores of a set as functions of p: one curve for each measure and stage."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.data.store import Embeddings
from omnivat.head.head import OmniVaT
from omnivat.kit.files import write_csv, write_json
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.shapes import floating, require_shapes
from omnivat.kit.stages import STILL
from omnivat.maps.sweep.walk import AtOrder, require_known, walk
from omnivat.measure.gaps.measures import (
    PREDICTION_MEASURES,
    ROW_MEASURES,
    STAGE_MEASURES,
    SUM_MEASURES,
    Facts,
)
from omnivat.measure.gaps.unit import unit

Curves = Mapping[str, Sequence[float | None]]


def write_curves_json(
    path: str | Path, orders: Sequence[float], curves: Curves, head: Mapping[str, Any]
) -> None:
    """Write `{"orders": [...], "head": {...}, "curves": {name: [...]}}`; null means undefined."""
    plain = {name: [_number(value) for value in values] for name, values in curves.items()}
    write_json(path, {"orders": list(orders), "head": dict(head), "curves": plain})


def write_curves_csv(path: str | Path, orders: Sequence[float], curves: Curves) -> None:
    """Write a column `order`, then one column for each curve; an empty cell means undefined."""
    rows = zip(orders, *(map(_number, values) for values in curves.values()), strict=True)
    write_csv(path, ["order", *curves], rows)  # None is an empty cell


def _number(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)


MEASURES = ("modality_gap", "domain_gap", "margin", "accuracy", "macro_f1")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sweep:
    """Curves over P orders for N pairs.

    curves  "measure/stage", "accuracy/all" and the like -> (P,); NaN if undefined. docs/gaps.md
            lists the names
    """

    orders: NDArray[np.float64]  # (P,) quarter turns, as given
    classes: tuple[str, ...]  # the head's K classes, then other classes of the set
    label: NDArray[np.int64]  # (N,) index into `classes`
    # (P, N, K), from both images; (P, 0, K) without prediction measures
    probabilities: NDArray[np.float32]
    curves: dict[str, NDArray[np.float64]] = field(default_factory=dict)


def sweep(
    model: OmniVaT,
    embeddings: Embeddings,
    orders: Sequence[float],
    *,
    stages: Sequence[str] = ("f_hat",),
    measures: Sequence[str] = MEASURES,
    on_step: OnStep = ignore,
) -> Sweep:
    """Measure gaps and predictions of a set at every order.

    orders    quarter turns, any real numbers
    stages    of `STAGES`; others are not kept
    measures  of `STAGE_MEASURES` and `PREDICTION_MEASURES`

    Memory holds one order's predictions, the probabilities of all orders and, for measures that are
    not of `SUM_MEASURES`, one order's features.
    Measures of the raw embedding and the raw DFrFT are computed once, because they do not depend on
    the order. Without prediction measures and other stages, the head runs at one order at most.
    Raises SettingsError for an unknown stage or measure, or an invalid order.

    >>> from omnivat import default_embeddings, default_head, load_embeddings, load_head
    >>> head, pairs = load_head(default_head()), load_embeddings(default_embeddings())
    >>> digit = pairs.in_domain("TQ-DIGIT-sim")
    >>> found = sweep(head.model, digit, [0.0, 0.5], measures=["modality_gap"])
    >>> found.curves["modality_gap/f_hat"].shape
    (2,)
    """
    given = floating("orders", orders)
    require_shapes(orders=(given, "P"))
    orders = given.tolist()
    require_known(measures, (*STAGE_MEASURES, *PREDICTION_MEASURES), "measure")
    classes, facts = facts_of(embeddings, model.settings.classes, model.classifier.device)
    predictions = any(name in PREDICTION_MEASURES for name in measures)
    count = len(embeddings) if predictions else 0
    result = Sweep(
        orders=np.array(orders, dtype=np.float64),
        classes=classes,
        label=facts.labels.cpu().numpy(),
        probabilities=np.zeros((len(orders), count, len(model.settings.classes)), dtype=np.float32),
    )
    summed = not any(name in ROW_MEASURES for name in measures)
    walked = walk(
        model,
        embeddings,
        orders,
        stages=stages,
        predictions=predictions,
        sums_for=facts if summed else None,
    )
    for found in walked:
        for stage, name, value in curve_values(found, facts, measures):
            curve = result.curves.setdefault(name, np.full(len(orders), np.nan))
            curve[slice(None) if stage in STILL else found.index] = value
        if predictions:
            result.probabilities[found.index] = found.probabilities["fused"].cpu().numpy()
        on_step(Step(done=found.index + 1, total=len(orders), text=f"order {found.order:.2f}"))
    return result


def curve_values(
    at_order: AtOrder, facts: Facts, measures: Sequence[str]
) -> Iterator[tuple[str, str, float]]:
    """Yield stage ("" for predictions), name and value of all curves at one order."""
    for stage in (*at_order.features, *at_order.sums):
        features, sums = at_order.features.get(stage, {}), at_order.sums.get(stage)
        if sums is None and any(name in SUM_MEASURES for name in measures):
            sums = facts.sums()
            sums.add(features)
        units: dict[str, Tensor] = {}
        for name in (name for name in measures if name in STAGE_MEASURES):
            if name in SUM_MEASURES and sums is not None:
                values = SUM_MEASURES[name](sums, facts)
            else:
                units = units or {modality: unit(rows) for modality, rows in features.items()}
                values = ROW_MEASURES[name](units, facts)
            for suffix, value in values:
                variant, _, domain = suffix.partition("/")
                tail = f"/{domain}" if domain else ""
                yield stage, f"{name}{variant}/{stage}{tail}", float(value)
    for name in measures:
        if name in PREDICTION_MEASURES and at_order.probabilities:
            for suffix, value in PREDICTION_MEASURES[name](at_order.probabilities, facts):
                yield "", f"{name}{suffix}", float(value)


def facts_of(
    embeddings: Embeddings, known: tuple[str, ...], device: torch.device | None = None
) -> tuple[tuple[str, ...], Facts]:
    """Return the classes, those in `known` first, and the facts that do not depend on the order.

    Pairs of a class that the head lacks count in gaps, not in scores.
    """
    header = embeddings.header
    classes = tuple(dict.fromkeys((*known, *header.classes)))
    index = torch.tensor([classes.index(name) for name in header.classes], dtype=torch.long)
    labels = index[torch.from_numpy(np.array(embeddings.label))].to(device)
    return classes, Facts(
        labels=labels,
        class_names=classes,
        domains=torch.from_numpy(np.array(embeddings.domain)).to(device),
        domain_names=header.domains,
        scored=labels < len(known),
    )
