"""Trainings for the study of the order: one job is one head, in this process or in several."""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from typing import Any

import numpy as np
import torch

from omnivat.data.store import Embeddings
from omnivat.head.head import OmniVaT
from omnivat.measure.evaluate import predicted_probabilities
from omnivat.measure.unseen import counted, mean_over_domains
from omnivat.simulate.chirps import ChirpSettings
from omnivat.training import TrainSettings, train
from omnivat.training.from_pairs import plan_training

CHIRP_HEAD = {"theta_init": "signed"}  # a spike of any phase must reach a token
SENSORS = TrainSettings(epochs=60)
# few large steps: a third of the time for many heads
QUICK_SENSORS = TrainSettings(epochs=40, batch=32, lr=0.1)
CHIRP_TRAINING = TrainSettings(epochs=30, batch=32, lr=0.1, lang=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """Accuracy (%) of one head on test pairs."""

    source_test: float
    unseen: float  # mean over unseen domains


def scored(model: OmniVaT, embeddings: Embeddings, source: str, order: float | None = None) -> Score:
    """Score a head on all domains of a set, at its own order or another."""
    shares = predicted_probabilities(model, embeddings, order=order)["fused"]
    right = shares.argmax(1).numpy() == labels_of(model, embeddings)
    keep = counted(embeddings, source)
    own = keep & (embeddings.domain == embeddings.header.domains.index(source))
    unseen = mean_over_domains(right, embeddings, source, keep)
    return Score(source_test=100 * float(right[own].mean()), unseen=float("nan") if unseen is None else 100 * unseen)


def labels_of(model: OmniVaT, embeddings: Embeddings) -> np.ndarray[Any, Any]:
    """Return the index (N,) of each pair's class in the head; -1 where the head lacks it."""
    index = [
        model.settings.classes.index(name) if name in model.settings.classes else -1
        for name in embeddings.header.classes
    ]
    return np.array(index)[embeddings.label]


def head_at(
    embeddings: Embeddings, source: str, order: float, seed: int, training: TrainSettings, head: dict[str, Any]
) -> OmniVaT:
    """Train a head with p fixed at `order`."""
    plan = plan_training(embeddings, source, head=head, training=training).at(order, seed)
    return train(plan.pairs, plan.settings, plan.training, bank=plan.bank, seed=seed).model


def chirp_head(settings: ChirpSettings, embeddings: Embeddings, order: float) -> OmniVaT:
    """Train a head of the signals' own width on the first domain of a set of chirps."""
    head = {**CHIRP_HEAD, "width": settings.width}
    source = settings.domain_names[0]
    return head_at(embeddings, source, order, settings.seed, CHIRP_TRAINING, head)


def other_seed(settings: ChirpSettings, seed: int) -> ChirpSettings:
    """Return chirps of another seed, with a new p* from [0.15, 0.85]."""
    drawn = float(np.random.default_rng([2026, seed]).uniform(0.15, 0.85))
    return replace(settings, seed=seed, order=drawn)


def carried_out(work: Callable[..., Any], jobs: Sequence[tuple[Any, ...]], processes: int) -> Iterable[Any]:
    """Return the results of `work(*job)` in the order of the jobs, one thread for each process."""
    if processes == 1:
        torch.set_num_threads(1)
        return (work(*job) for job in jobs)
    return _in_processes(work, jobs, processes)


def _in_processes(work: Callable[..., Any], jobs: Sequence[tuple[Any, ...]], processes: int) -> Iterable[Any]:
    with ProcessPoolExecutor(
        processes, mp_context=get_context("spawn"), initializer=torch.set_num_threads, initargs=(1,)
    ) as pool:
        yield from pool.map(work, *zip(*jobs, strict=True))
