"""Search for p by short trainings: a coarse grid over [0, 1], then a fine one around the best stop.

The gradient cannot find p: the loss has a valley of width about 1/D, and it is flat elsewhere
(docs/order.md). A short training at a fixed p costs little, and its log loss on held-out source
pairs measures how good that p is. The search uses no other domain.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.data.splits import hold_out
from omnivat.data.store import Embeddings
from omnivat.evaluate import predicted_probabilities
from omnivat.lang.bank import LangBank
from omnivat.model.settings import HeadSettings
from omnivat.seeding import derive_seed
from omnivat.train.batches import labels_of
from omnivat.train.loop import steps_of, train_once
from omnivat.train.settings import TrainSettings
from omnivat.train.watch import Watch

HELD = 0.3  # of the source's objects
COARSE_STEPS, FINE_STEPS = 42, 84  # optimiser steps of a short training
COARSE_FOLDS, FINE_FOLDS = 1, 2
FINE = (-0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75)  # of the coarse grid's step
RATE, BATCH = 2.0, 2  # factor of the learning rate: short trainings take few, large steps


@dataclass(frozen=True, slots=True, kw_only=True)
class Scored:
    """Held-out log loss of short trainings at one order."""

    order: float
    score: float  # mean over held-out pairs
    spread: float  # its standard error
    round: str  # "coarse" or "fine"


def search_steps(pairs: int, settings: TrainSettings) -> int:
    """Return the number of optimiser steps of a search over this many source pairs."""
    fit = pairs - round(HELD * pairs)
    coarse, fine = (_short(settings, fit, steps) for steps in (COARSE_STEPS, FINE_STEPS))
    return COARSE_FOLDS * settings.order_stops * coarse.epochs * steps_of(
        fit, coarse
    ) + FINE_FOLDS * len(FINE) * fine.epochs * steps_of(fit, fine)


def search_order(
    source: Embeddings,
    head: HeadSettings,
    settings: TrainSettings,
    *,
    bank: LangBank | None,
    seed: int,
    watch: Watch,
) -> dict[str, Any]:
    """Return the best order for the source, and the curve behind it.

    return  "start" the order found; "orders", "score", "spread", "round" one entry for each short
            training (score: log loss on held-out source pairs, lower is better; spread: its
            standard error); "seconds" and "steps" the cost of the search

            The initial order in `head` has no effect. Orders outside [0, 1] repeat those inside.
    """
    began = time.monotonic()
    watch = watch if watch.whole else watch.part(0, search_steps(len(source), settings))
    search = _Search(source, head, settings, bank, seed, watch)
    grid = [step / (settings.order_stops - 1) for step in range(settings.order_stops)]
    coarse = search.round(grid, COARSE_FOLDS, COARSE_STEPS, "coarse")
    best = min(coarse, key=lambda found: found.score).order
    around = [best + share / (settings.order_stops - 1) for share in FINE]
    fine = search.round(around, FINE_FOLDS, FINE_STEPS, "fine")
    found = (*coarse, *fine)
    return {
        "start": lowest_point([(one.order, one.score) for one in fine]),
        "orders": [one.order for one in found],
        "score": [one.score for one in found],
        "spread": [one.spread for one in found],
        "round": [one.round for one in found],
        "steps": search.steps,
        "seconds": round(time.monotonic() - began, 2),
    }


def lowest_point(points: Sequence[tuple[float, float]]) -> float:
    """Return the minimum of a parabola through (order, score), or the best order if it has none.

    >>> round(lowest_point([(0.2, 1.0), (0.3, 0.5), (0.4, 1.0)]), 6)
    0.3
    """
    orders, scores = np.array(points, dtype=float).T
    best = float(orders[scores.argmin()])
    depth = float(np.median(scores) - scores.min()) or 1.0
    weight = depth / (scores - scores.min() + 0.2 * depth)  # low scores have the largest weights
    curve, slope, _ = np.polyfit(orders - best, scores, 2, w=weight)
    if curve <= 0:
        return best
    return float(np.clip(best - slope / (2 * curve), orders.min(), orders.max()))


class _Search:
    """Short trainings at fixed orders on folds of one source."""

    def __init__(
        self,
        source: Embeddings,
        head: HeadSettings,
        settings: TrainSettings,
        bank: LangBank | None,
        seed: int,
        watch: Watch,
    ) -> None:
        self.source, self.head, self.settings, self.bank = source, head, settings, bank
        self.seed, self.watch = seed, watch
        self.labels = labels_of(source, head)
        self.steps = 0

    def round(
        self, orders: Sequence[float], folds: int, steps: int, name: str
    ) -> tuple[Scored, ...]:
        """Score each order by trainings with this many steps on each fold."""
        found = []
        for order in orders:
            losses = np.concatenate(
                [self._losses(order, fold, steps, name) for fold in range(folds)]
            )
            spread = float(losses.std(ddof=1) / len(losses) ** 0.5) if len(losses) > 1 else 0.0
            found.append(Scored(order=order, score=float(losses.mean()), spread=spread, round=name))
        return tuple(found)

    def _losses(self, order: float, fold: int, steps: int, name: str) -> NDArray[np.float64]:
        """Train briefly at an order; return the log loss (N,) of the fold's held-out pairs."""
        seed = derive_seed(self.seed, "order-search", name, fold)
        held = hold_out(self.source.rows["object"], self.labels, HELD, seed=seed)
        if not held.any():  # one object for each class: score on the training pairs
            held[:] = True
            fit = self.source
        else:
            fit = self.source.select(~held)
        short = _short(self.settings, len(fit), steps)
        count = short.epochs * steps_of(len(fit), short)
        model = train_once(
            fit,
            replace(self.head, order=order, learn_order=False),
            short,
            bank=self.bank,
            seed=seed,
            resume=None,
            watch=self.watch.part(self.watch.done + self.steps, self.watch.whole),
        ).model
        self.steps += count
        shares = predicted_probabilities(
            model, self.source.select(held), modalities=self.settings.given
        )["fused"]
        right = shares.gather(1, torch.from_numpy(self.labels[held])[:, None])[:, 0]
        losses: NDArray[np.float64] = -right.double().clamp_min(1e-12).log().numpy()
        return losses


def _short(settings: TrainSettings, pairs: int, steps: int) -> TrainSettings:
    """Return the settings of a short training with about this many steps."""
    short = replace(
        settings,
        order_search=False,
        selection="last",
        batch=BATCH * settings.batch,
        lr=RATE * settings.lr,
    )
    return replace(short, epochs=max(1, round(steps / steps_of(pairs, short))))
