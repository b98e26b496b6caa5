"""Walk a set of embeddings through many orders: features, answers and gaps as functions of p."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.data.store import Embeddings
from omnivat.errors import SettingsError
from omnivat.gaps.measures import ANSWER_MEASURES, STAGE_MEASURES, Facts
from omnivat.gaps.unit import unit
from omnivat.model.head import OmniVaT, PairCoefficients
from omnivat.model.output import HeadOutput
from omnivat.progress import OnStep, Step, ignore
from omnivat.tables import suggestion

# Each stage of the head that can be seen. Raw embedding and raw DFrFT do not depend on the order:
# the transform is unitary, so every distance and cosine stays.
STAGES = ("raw", "frft", "relu", "f_bar", "f_hat")
STILL = ("raw", "frft")
MEASURES = ("modality_gap", "domain_gap", "margin", "accuracy", "macro_f1")
CHUNK = 512  # pairs that pass the head at once: bounds the memory, whatever the set

Features = Mapping[str, Tensor]  # modality -> (N, W), rows of any length


@dataclass(frozen=True, slots=True, kw_only=True)
class AtOrder:
    """What was found at one order.

    index          place of the order in the list that was asked for
    features       stage -> modality -> (N, W); only stages that were asked for and that move,
                   and at the first order visited also those that do not
    probabilities  "fused", "vis", "tac" -> (N, K); empty when no answers were asked for
    """

    index: int
    order: float
    features: Mapping[str, Features]
    probabilities: Mapping[str, Tensor]


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


def coarse_first(count: int) -> list[int]:
    """Return 0 .. count - 1, the ends first, then ever finer steps between them.

    >>> coarse_first(9)
    [0, 8, 4, 2, 6, 1, 3, 5, 7]
    """
    ends = {0, count - 1}
    inner = sorted(set(range(count)) - ends, key=lambda i: (-(i & -i), i))
    return sorted(ends & set(range(count))) + inner


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
    chunk     pairs that pass the head at once. Memory is one order's features and answers, and
              the probabilities of all orders

    Measures of the raw embedding and the raw DFrFT are computed once and hold for every order.
    Without answer measures and moving stages the head is asked for one order at most.
    Raises SettingsError for a stage, measure or order that cannot be.
    """
    _require_known(measures, (*STAGE_MEASURES, *ANSWER_MEASURES), "measure")
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
    walked = walk(
        model, embeddings, orders, stages=stages, answers=bool(answers), visits=visits, chunk=chunk
    )
    for done, found in enumerate(walked, start=1):
        for stage, name, value in measured(found, facts, measures):
            curve = result.curves.setdefault(name, np.full(len(orders), np.nan))
            curve[slice(None) if stage in STILL else found.index] = value
        if answers:
            result.probabilities[found.index] = found.probabilities["fused"].cpu().numpy()
        on_step(Step(done=done, total=len(visits), text=f"order {found.order:.2f}"))
    return result


def walk(
    model: OmniVaT,
    embeddings: Embeddings,
    orders: Sequence[float],
    *,
    stages: Sequence[str] = (),
    answers: bool = True,
    visits: Sequence[int] | None = None,
    chunk: int = CHUNK,
) -> Iterator[AtOrder]:
    """Give what is found at each order, one order at a time, in the order of `visits`.

    Orders at which nothing would move are not visited: with still stages alone and no answers,
    only the first is.
    """
    _require_known(stages, STAGES, "stage")
    if chunk < 1 or not np.isfinite(np.array(orders, dtype=np.float64)).all():
        raise SettingsError("chunk must be 1 or more and every order a finite number.")
    visits = list(range(len(orders))) if visits is None else list(visits)
    moving = [stage for stage in stages if stage not in STILL]
    if not moving and not answers:
        visits = visits[:1]
    kept: PairCoefficients | None = None
    for place, index in enumerate(visits):
        order = float(orders[index])
        wanted = [stage for stage in stages if stage != "raw"] if place == 0 else moving
        features: dict[str, Features] = {}
        if place == 0 and "raw" in stages:
            features["raw"] = _raw(model, embeddings)
        probabilities: Mapping[str, Tensor] = {}
        if wanted or answers:
            kept = coefficients_of(model, embeddings) if kept is None else kept
            moved, probabilities = _pass(model, kept, order, wanted, answers, chunk)
            features |= moved
        yield AtOrder(index=index, order=order, features=features, probabilities=probabilities)


@torch.no_grad()
def coefficients_of(model: OmniVaT, embeddings: Embeddings) -> PairCoefficients:
    """Return what to keep of all pairs while the order moves."""
    raw = _raw(model, embeddings)
    return model.coefficients(raw["vis"], raw["tac"])


@torch.no_grad()
def _pass(
    model: OmniVaT,
    kept: PairCoefficients,
    order: float,
    stages: Sequence[str],
    answers: bool,
    chunk: int,
) -> tuple[dict[str, Features], dict[str, Tensor]]:
    """Run all pairs through the head at one order, `chunk` at a time; keep what is asked for."""
    features: dict[tuple[str, str], list[Tensor]] = {}
    probabilities: dict[str, list[Tensor]] = {}
    for start in range(0, len(kept), chunk):
        output = model.from_coefficients(kept[start : start + chunk], order)
        for stage in stages:
            for modality, rows in stage_features(output, stage).items():
                features.setdefault((stage, modality), []).append(rows)
        if answers:
            for name, rows in {
                "fused": output.probabilities,
                **output.modality_probabilities,
            }.items():
                probabilities.setdefault(name, []).append(rows)
    joined: dict[str, dict[str, Tensor]] = {stage: {} for stage in stages}
    for (stage, modality), parts in features.items():
        joined[stage][modality] = torch.cat(parts)
    return dict(joined), {name: torch.cat(parts) for name, parts in probabilities.items()}


def stage_features(output: HeadOutput, stage: str) -> Features:
    """Return the rows of a stage by modality: (B, D), or (B, 2D) with Re before Im."""
    return {name: rows.flatten(1) for name, rows in getattr(output, stage).items()}


def measured(
    found: AtOrder, facts: Facts, measures: Sequence[str]
) -> Iterator[tuple[str, str, float]]:
    """Give every curve's value at one order: stage ("" for answers), name of the curve, value."""
    for stage, features in found.features.items():
        units = {name: unit(rows) for name, rows in features.items()}
        for name in measures:
            if name in STAGE_MEASURES:
                for suffix, value in STAGE_MEASURES[name](units, facts):
                    variant, _, domain = suffix.partition("/")
                    tail = f"/{domain}" if domain else ""
                    yield stage, f"{name}{variant}/{stage}{tail}", float(value)
    for name in measures:
        if name in ANSWER_MEASURES and found.probabilities:
            for suffix, value in ANSWER_MEASURES[name](found.probabilities, facts):
                yield "", f"{name}{suffix}", float(value)


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
        domains=torch.from_numpy(np.array(embeddings.domain)).to(device),
        domain_names=header.domains,
        scored=labels < len(known),
    )


def _raw(model: OmniVaT, embeddings: Embeddings) -> Features:
    device = model.classifier.device
    # copies: what is memory-mapped may be read-only
    return {
        "vis": torch.from_numpy(np.array(embeddings.vis)).to(device),
        "tac": torch.from_numpy(np.array(embeddings.tac)).to(device),
    }


def _require_known(names: Sequence[str], known: Sequence[str], kind: str) -> None:
    for name in names:
        if name not in known:
            raise SettingsError(
                f"No {kind} is called '{name}'; there are {', '.join(known)}."
                f"{suggestion(name, known)}"
            )
