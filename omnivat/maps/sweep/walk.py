"""Visit orders one at a time, and compute features and predictions of a set at each."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
from torch import Tensor

from omnivat.data.store import Embeddings
from omnivat.head.head import OmniVaT, PairCoefficients
from omnivat.head.output import HeadOutput
from omnivat.head.predict_set import blocks
from omnivat.kit.errors import DataError, SettingsError
from omnivat.kit.progress import checkpoint
from omnivat.kit.stages import STAGES, STILL
from omnivat.kit.tables import unknown
from omnivat.measure.gaps.measures import Facts
from omnivat.measure.gaps.sums import Sums

CHUNK = 512  # pairs in one pass of the head; it bounds the memory for any set
KEPT_PAIRS = 20_000  # pairs whose coefficients are kept for all orders; beyond, they are recomputed

Features = Mapping[str, Tensor]  # modality -> (N, W), rows of any length


@dataclass(frozen=True, slots=True, kw_only=True)
class AtOrder:
    """The results at one order.

    features  by stage: requested stages that depend on the order; at the first order, also those
              that do not
    """

    index: int  # of the order in the given list
    order: float
    features: Mapping[str, Features]
    # reading -> (N, K); empty if predictions were not requested
    probabilities: Mapping[str, Tensor]
    # by stage, instead of features if requested
    sums: Mapping[str, Sums] = field(default_factory=dict)


def walk(
    model: OmniVaT | None,
    embeddings: Embeddings,
    orders: Sequence[float],
    *,
    stages: Sequence[str] = (),
    still: Sequence[str] = STILL,
    predictions: bool = True,
    sums_for: Facts | None = None,
    kept: PairCoefficients | None = None,
) -> Iterator[AtOrder]:
    """Yield the results at each order.

    model     None for the raw stage without predictions
    still     stages that do not depend on the order
    sums_for  yield sums of the features by these labels and domains instead of features; memory is
              then that of the predictions
    kept      `coefficients_of` the pairs, if they were computed before

    If no requested result depends on the order, only the first order is visited. Raises
    SettingsError for an unknown stage or an order that is not finite, DataError if there are no
    pairs.
    """
    require_known(stages, STAGES, "stage")
    if not np.isfinite(np.array(orders, dtype=np.float64)).all():
        raise SettingsError("Every order must be a finite number.")
    moving = [stage for stage in stages if stage not in still]
    if not moving and not predictions:
        orders = orders[:1]
    for index, order in enumerate(map(float, orders)):
        wanted = [stage for stage in stages if stage != "raw"] if index == 0 else moving
        found = _Found(len(embeddings), sums_for)
        if index == 0 and "raw" in stages:
            for rows, raw in _raw_chunks(model, embeddings, CHUNK):
                found.take("raw", raw, rows)
        if model is not None and (wanted or predictions):
            if kept is None and len(embeddings) <= KEPT_PAIRS:
                kept = coefficients_of(model, embeddings)
            for rows, output in _outputs(model, embeddings, kept, order):
                for stage in wanted:
                    found.take(stage, stage_features(output, stage), rows)
                if predictions:
                    found.take("", output.readings, rows)
        probabilities = found.whole.pop("", {})
        yield AtOrder(
            index=index,
            order=order,
            features=found.whole,
            probabilities=probabilities,
            sums=found.sums,
        )


class _Found:
    """Collect the results at one order, some rows at a time."""

    def __init__(self, count: int, facts: Facts | None) -> None:
        self.whole: dict[str, dict[str, Tensor]] = {}
        self.sums: dict[str, Sums] = {}
        self.count, self.facts = count, facts

    def take(self, stage: str, batch: Features, rows: slice) -> None:
        """Add the features of some rows, or their predictions if the stage is ""."""
        if stage and (facts := self.facts) is not None:
            sums = self.sums.setdefault(stage, facts.sums())
            sums.add(batch, rows)
            return
        into = self.whole.setdefault(stage, {})
        for name, values in batch.items():
            if name not in into:
                into[name] = values.new_empty(self.count, *values.shape[1:])
            into[name][rows] = values


@torch.no_grad()
def stage_blocks(
    model: OmniVaT | None, embeddings: Embeddings, order: float | None, stage: str
) -> Iterator[tuple[slice, Features]]:
    """Yield the features of one stage at one order, some pairs at a time, with their slice.

    model, order  None at "raw", whose blocks are larger: they cost no memory to speak of
    Raises DataError if there are no pairs.
    """
    if model is None or order is None:
        yield from _raw_chunks(model, embeddings, 8 * CHUNK)
        return
    for rows, output in _outputs(model, embeddings, None, order):
        yield rows, stage_features(output, stage)


@torch.no_grad()
def coefficients_of(model: OmniVaT, embeddings: Embeddings) -> PairCoefficients:
    """Return the coefficients of all pairs."""
    _, raw = next(_raw_chunks(model, embeddings, len(embeddings)))
    return model.coefficients(raw["vis"], raw["tac"])


@torch.no_grad()
def _outputs(
    model: OmniVaT, embeddings: Embeddings, kept: PairCoefficients | None, order: float
) -> Iterator[tuple[slice, HeadOutput]]:
    """Yield the head's outputs, some pairs at a time, from kept coefficients if possible."""
    if kept is None:
        for rows, raw in _raw_chunks(model, embeddings, CHUNK):
            yield rows, model.from_coefficients(model.coefficients(**raw), order)
        return
    for start in range(0, len(kept), CHUNK):
        checkpoint()
        rows = slice(start, start + CHUNK)
        yield rows, model.from_coefficients(kept[rows], order)


def stage_features(output: HeadOutput, stage: str) -> Features:
    """Return the rows of a stage by modality: (B, D), or (B, 2D) with Re before Im."""
    return {name: rows.movedim(-2, 0).flatten(1) for name, rows in getattr(output, stage).items()}


def _raw_chunks(
    model: OmniVaT | None, embeddings: Embeddings, chunk: int
) -> Iterator[tuple[slice, dict[str, Tensor]]]:
    if not len(embeddings):
        raise DataError("There are no pairs in these embeddings; choose a set with pairs.")
    return blocks(embeddings, model.classifier.device if model else None, size=chunk)


def require_known(names: Sequence[str], known: Sequence[str], kind: str) -> None:
    """Raise SettingsError for an unknown name; the message lists the known ones."""
    for name in names:
        if name not in known:
            raise SettingsError(unknown(name, known, kind=kind))
