"""Visit orders one at a time: the features and answers of a set of embeddings at each."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from omnivat.data.store import Embeddings
from omnivat.errors import DataError, SettingsError
from omnivat.model.head import OmniVaT, PairCoefficients
from omnivat.model.output import HeadOutput
from omnivat.tables import suggestion

# Each stage of the head that can be seen. Raw embedding and raw DFrFT do not depend on the order:
# the transform is unitary, so every distance and cosine stays.
STAGES = ("raw", "frft", "relu", "f_bar", "f_hat")
STILL = ("raw", "frft")
CHUNK = 512  # pairs that pass the head at once: bounds the memory, whatever the set

Features = Mapping[str, Tensor]  # modality -> (N, W), rows of any length


@dataclass(frozen=True, slots=True, kw_only=True)
class AtOrder:
    """What was found at one order.

    index          place of the order in the list that was asked for
    features       stage -> modality -> (N, W); only stages that were asked for and that move,
                   and at the first order visited also those that do not
    probabilities  reading -> (N, K): "fused", "vis" and "tac" alone, "vis_branch" and "tac_branch"
                   inside the pair; empty when no answers were asked for
    """

    index: int
    order: float
    features: Mapping[str, Features]
    probabilities: Mapping[str, Tensor]


def coarse_first(count: int) -> list[int]:
    """Return 0 .. count - 1, the ends first, then ever finer steps between them.

    >>> coarse_first(9)
    [0, 8, 4, 2, 6, 1, 3, 5, 7]
    """
    ends = {0, count - 1}
    inner = sorted(set(range(count)) - ends, key=lambda i: (-(i & -i), i))
    return sorted(ends & set(range(count))) + inner


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

    Raises SettingsError for an unknown stage or an order that is not finite, DataError where
    there are no pairs.
    """
    require_known(stages, STAGES, "stage")
    if chunk < 1 or not np.isfinite(np.array(orders, dtype=np.float64)).all():
        raise SettingsError("chunk must be 1 or more and every order a finite number.")
    if not len(embeddings):
        raise DataError("There are no pairs in these embeddings; choose a set with pairs.")
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
            for name, rows in output.readings.items():
                probabilities.setdefault(name, []).append(rows)
    joined: dict[str, dict[str, Tensor]] = {stage: {} for stage in stages}
    for (stage, modality), parts in features.items():
        joined[stage][modality] = torch.cat(parts)
    return dict(joined), {name: torch.cat(parts) for name, parts in probabilities.items()}


def stage_features(output: HeadOutput, stage: str) -> Features:
    """Return the rows of a stage by modality: (B, D), or (B, 2D) with Re before Im."""
    return {name: rows.flatten(1) for name, rows in getattr(output, stage).items()}


def _raw(model: OmniVaT, embeddings: Embeddings) -> Features:
    device = model.classifier.device
    # copies: what is memory-mapped may be read-only
    return {
        "vis": torch.from_numpy(np.array(embeddings.vis)).to(device),
        "tac": torch.from_numpy(np.array(embeddings.tac)).to(device),
    }


def require_known(names: Sequence[str], known: Sequence[str], kind: str) -> None:
    """Refuse a name that is not known, with those that are. Raises SettingsError."""
    for name in names:
        if name not in known:
            raise SettingsError(
                f"No {kind} is called '{name}'; there are {', '.join(known)}."
                f"{suggestion(name, known)}"
            )
