"""Search for p without training: closed-form classifiers at every order.

The gradient cannot find p: the loss has a valley of width about 1/D, and it is flat elsewhere
(docs/order.md). At each order of a grid, ridge regressions predict the class: from the tokens that
the head would see, and from |F_p z|², in which a random phase has no part. Their error on pairs
left out measures how good that order is. The search uses no other domain.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.data.store import Embeddings
from omnivat.fractional import Coefficients, coefficients, synthesise
from omnivat.head.head import OmniVaT, build_head
from omnivat.head.settings import HeadSettings
from omnivat.kit.seeding import derive_seed
from omnivat.training.batches import labels_of
from omnivat.training.settings import TrainSettings
from omnivat.training.watch import Watch

MOST = 256  # pairs of the source; more would cost time and change little
FEWEST_STOPS, MOST_STOPS = 21, 2001  # of the coarse grid
RIDGE = 1.0  # of the mean squared length of the centred tokens
FINE = tuple(k / 8 for k in range(-8, 9))  # of the coarse grid's step
VALLEYS = 3  # refined, the lowest ones
APART = 4.0  # over D: orders nearer than this share a valley
# Standard errors of a paired difference between orders that tie. Pairs left out share all others,
# so their losses vary together and two are too few (docs/order.md).
DOUBT = 3.0
Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scored:
    """Errors of the classifiers at one order, for every pair left out; 1 is that of the class
    shares.
    """

    order: float
    losses: Array  # (classifier, N)
    round: str  # "coarse" or "fine"

    @property
    def score(self) -> float:
        """The mean over classifiers; one that is worse than chance counts as chance."""
        return float(self.losses.mean(1).clip(max=1.0).mean())

    @property
    def spread(self) -> float:
        """The standard error of the mean."""
        return float(self.losses.mean(0).std(ddof=1) / self.losses.shape[1] ** 0.5)


def stops_of(head: HeadSettings) -> int:
    """Return the number of coarse orders from 0 to 1: a step is at most 1/D wide."""
    return max(FEWEST_STOPS, min(head.width + 1, MOST_STOPS))


def search_steps(head: HeadSettings) -> int:
    """Return the number of orders that a search scores."""
    return stops_of(head) + VALLEYS * len(FINE)


def search_order(
    source: Embeddings, head: HeadSettings, settings: TrainSettings, *, seed: int, watch: Watch
) -> dict[str, Any]:
    """Return the best order for the source, and the curve behind it.

    return  "start" the order; "orders", "score", "spread", "round" one entry for each order scored
            (score: mean squared error on pairs left out over that of the class shares, mean of six
            classifiers: tokens and energies, each of photo only, touch only and both; 1 is chance,
            lower is better; spread: its standard error); "between" the lowest and highest order
            around the best that the source cannot tell from it, "ties" the best such order in each
            other valley, "note" both in words; "seconds" and "steps" the cost of the search

    The initial order in `head` has no effect. Orders outside [0, 1] repeat those inside.
    """
    began = time.monotonic()
    scores = _Scores(source, head, settings, seed, watch)
    step = 1 / (stops_of(head) - 1)
    coarse = [scores.at(k * step, "coarse") for k in range(stops_of(head))]
    valleys = lowest_valleys(coarse, APART / head.width)
    fine = [[scores.at(v.order + share * step, "fine") for share in FINE] for v in valleys]
    bottom = min(fine, key=lambda valley: min(trial.score for trial in valley))
    everything = (*coarse, *(trial for found in fine for trial in found))
    start = folded(lowest_point([(trial.order, trial.score) for trial in bottom]))
    best = min(bottom, key=lambda scored: scored.score)
    ties = tied(everything, best, APART / head.width)
    low, high = neighbours(everything, best)
    between = round(min(low, start), 4), round(max(high, start), 4)
    return {
        "start": start,
        "orders": [trial.order for trial in everything],
        "score": [trial.score for trial in everything],
        "spread": [trial.spread for trial in everything],
        "round": [trial.round for trial in everything],
        "between": list(between),
        "ties": ties,
        "note": _note(start, between, ties),
        "steps": len(everything),
        "seconds": round(time.monotonic() - began, 2),
    }


def lowest_valleys(scored: Sequence[Scored], apart: float) -> list[Scored]:
    """Return VALLEYS orders: the lowest ones further apart than this, then the lowest others."""
    chosen: list[Scored] = []
    others: list[Scored] = []
    for trial in sorted(scored, key=lambda scored: scored.score):
        far = all(abs(trial.order - other.order) > apart for other in chosen)
        (chosen if far else others).append(trial)
    return [*chosen, *others][:VALLEYS]


def tied(scored: Sequence[Scored], best: Scored, apart: float) -> list[float]:
    """Return the orders in other valleys that are within DOUBT standard errors of the best.

    The error is that of the paired difference over pairs, so it is small where both orders fail on
    the same pairs. Orders are further than `apart` from each other, the lowest first.
    """
    ties: list[float] = []
    for trial in sorted(scored, key=lambda scored: scored.score):
        near = (folded(other) for other in (best.order, *ties))
        if any(abs(folded(trial.order) - other) <= apart for other in near):
            continue
        if _as_good(trial, best):
            ties.append(round(folded(trial.order), 4))
    return ties


def neighbours(scored: Sequence[Scored], best: Scored) -> tuple[float, float]:
    """Return the ends, within [0, 1], of the run of scored orders around the best that tie with
    it.
    """
    ends = []
    for side in (-1, 1):
        beyond = [trial for trial in scored if side * (trial.order - best.order) > 0]
        beyond.sort(key=lambda scored: abs(scored.order - best.order))
        run = takewhile(lambda scored: _as_good(scored, best), beyond)
        *_, end = (best.order, *(scored.order for scored in run))
        ends.append(min(max(end, 0.0), 1.0))
    low, high = ends
    return low, high


def _as_good(scored: Scored, best: Scored) -> bool:
    more = (scored.losses - best.losses).mean(0)
    return bool(more.mean() <= DOUBT * more.std(ddof=1) / len(more) ** 0.5)


def _note(start: float, between: Sequence[float], ties: Sequence[float]) -> str:
    low, high = between
    if not ties:
        return (
            f"p = {start:.3f}; orders outside {low:.3f} to {high:.3f} are worse by three standard"
            " errors."
        )
    others = ", ".join(f"{p:.3f}" for p in ties[:3]) + (" and others" if len(ties) > 3 else "")
    return (
        f"p = {start:.3f} (as good from {low:.3f} to {high:.3f}) ties with {others}: the source"
        " alone does not tell them apart. Compare heads at each of them on another domain."
    )


def folded(order: float) -> float:
    """Return the order in [0, 1] whose transform of a real signal has the same magnitudes."""
    order = abs(order) % 2.0
    return min(order, 2.0 - order)


def lowest_point(points: Sequence[tuple[float, float]]) -> float:
    """Return the minimum of a parabola through (order, score), or the best order if it has none."""
    orders, scores = np.array(points, dtype=float).T
    best = float(orders[scores.argmin()])
    depth = float(np.median(scores) - scores.min()) or 1.0
    weight = depth / (scores - scores.min() + 0.2 * depth)  # low scores have the largest weights
    curve, slope, _ = np.polyfit(orders - best, scores, 2, w=weight)
    if curve <= 0:
        return best
    return float(np.clip(best - slope / (2 * curve), orders.min(), orders.max()))


class _Scores:
    """Scores orders on one source, for a head before its training."""

    def __init__(
        self,
        source: Embeddings,
        head: HeadSettings,
        settings: TrainSettings,
        seed: int,
        watch: Watch,
    ) -> None:
        random = np.random.default_rng(derive_seed(seed, "order-search"))
        source = source.select(np.sort(random.permutation(len(source))[:MOST]))
        self.model: OmniVaT = build_head(head, seed=derive_seed(seed, "weights")).eval()
        self.targets = np.eye(len(head.classes))[labels_of(source, head)]
        self.targets -= self.targets.mean(0)
        self.groups = _groups(source.rows["object"], self.targets.argmax(1))
        given = {n: torch.from_numpy(np.array(getattr(source, n))) for n in settings.given}
        with torch.inference_mode():
            self.kept: Coefficients = coefficients(self.model.embedded(given))  # (M, N)
        self.watch, self.total, self.count = watch, search_steps(head), 0

    def at(self, order: float, name: str) -> Scored:
        """Score one order by tokens and energies of the readings photo only, touch only and
        both.
        """
        self.count += 1
        self.watch.step(self.count, self.total, f"order {order:.3f}")
        with torch.inference_mode():
            parts = self.model.mffa.channels(synthesise(self.kept, order, planar=True))
            tokens = torch.cat((parts.relu(), (-parts).relu())).movedim(0, 2).flatten(2)
            energies = parts.square().sum(0)  # (M, N, D)
            grams = [*_grams(tokens), *_grams(energies)]
            losses = [_left_out(gram, self.targets, self.groups) for gram in grams]
        scale = (self.targets**2).sum(1).mean()
        return Scored(order=order, losses=np.array(losses) / scale, round=name)


def _grams(rows: Tensor) -> list[Tensor]:
    """Return inner products (N, N) of centred rows (M, N, C), mean squared length 1, and their
    mean.
    """
    rows = rows - rows.mean(1, keepdim=True)
    grams = (rows @ rows.mT).double()
    grams /= grams.diagonal(dim1=1, dim2=2).mean(1).clamp_min(1e-12)[:, None, None]
    return [*grams, grams.mean(0)] if len(grams) > 1 else [*grams]


def _groups(objects: Sequence[str], labels: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Return the row numbers of each object.

    Each row is a group of its own if a class has a single object or a row lacks an object's name.
    """
    named = np.array(objects)
    groups = [np.flatnonzero(named == name) for name in dict.fromkeys(objects)]
    counts = np.bincount([labels[group[0]] for group in groups], minlength=labels.max() + 1)
    if "" in objects or counts.min() < 2:
        return list(np.arange(len(labels))[:, None])
    return groups


def _left_out(gram: Tensor, targets: Array, groups: Sequence[NDArray[np.int64]]) -> Array:
    """Return the squared error (N,) of ridge regression for each pair, its object left out.

    With hat matrix H, the residual of a group g left out is (I - H_gg)⁻¹ (y - Hy)_g.
    """
    count = len(gram)
    factor = torch.linalg.cholesky(gram + RIDGE * torch.eye(count, dtype=gram.dtype))
    rest = RIDGE * torch.cholesky_inverse(factor).numpy() - 1 / count  # I - H, with the mean
    residual = rest @ targets
    if len(groups) == count:
        residual /= np.diag(rest)[:, None]
    else:
        for group in groups:
            residual[group] = np.linalg.solve(rest[np.ix_(group, group)], residual[group])
    squared: Array = (residual**2).sum(1)
    return squared
