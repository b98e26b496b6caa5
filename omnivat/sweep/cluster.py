"""Curves over p on a Ray cluster: one task for each order, for sets past one machine."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.checkpoint import load_head
from omnivat.data.store import load_embeddings
from omnivat.progress import OnStep, Step, ignore
from omnivat.stages import STILL
from omnivat.sweep.curves import sweep
from omnivat.tables import need
from omnivat.threads import one_thread


def curves_on_ray(
    head: Path,
    embeddings: Path,
    orders: Sequence[float],
    *,
    stages: Sequence[str],
    measures: Sequence[str],
    on_step: OnStep = ignore,
) -> dict[str, NDArray[np.float64]]:
    """Return the curves (P,) that `omnivat.sweep.sweep` gives, by name; each order is one task.

    head, embeddings  paths that every machine of the cluster can read
    orders            P quarter turns

    It uses the connected cluster, or the one of $RAY_ADDRESS, or starts Ray here.
    """
    ray = need("ray", purpose="a sweep on a cluster", install="ray")
    ray.init(ignore_reinit_error=True)
    remote: Callable[..., Any] = ray.remote(_at).remote
    moving = tuple(stage for stage in stages if stage not in STILL)
    files = str(Path(head).absolute()), str(Path(embeddings).absolute())
    tasks = {
        remote(*files, float(order), stages if index == 0 else moving, tuple(measures)): index
        for index, order in enumerate(orders)
    }
    curves: dict[str, NDArray[np.float64]] = {}
    waiting = list(tasks)
    while waiting:
        done, waiting = ray.wait(waiting, num_returns=1)
        index = tasks[done[0]]
        for name, value in ray.get(done[0]).items():
            still = name.split("/")[1] in STILL  # it holds for every order
            curve = curves.setdefault(name, np.full(len(orders), np.nan))
            curve[slice(None) if still else index] = value
        on_step(Step(done=len(tasks) - len(waiting), total=len(tasks), text=f"order {orders[index]:.2f}"))
    return curves


def _at(head: str, embeddings: str, order: float, stages: Sequence[str], measures: Sequence[str]) -> dict[str, float]:
    """Return every curve's value at one order, in a worker of one core."""
    with one_thread():
        model = load_head(head).model
        found = sweep(model, load_embeddings(embeddings), [order], stages=stages, measures=measures)
    return {name: float(values[0]) for name, values in found.curves.items()}
