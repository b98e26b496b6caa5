"""Probabilities, confidence and bootstrap draws of `benchmarks.recompute`, with no code of the reports."""

from base64 import b64decode
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

DRAWS = 1000
Target = tuple[str, str, str]  # truth and prediction of each pair, and its object's number, as text
Said = tuple[str, int, Mapping[str, Target]]  # source, seed, domain -> target


def probabilities(target: Mapping[str, Any], classes: int, temperature: float) -> np.ndarray[Any, Any]:
    """Return (N, K) from the stored log-odds against the last class."""
    odds = np.frombuffer(b64decode(target["odds"]), "<f2").reshape(-1, classes - 1).astype(float)
    values = np.pad(odds, ((0, 0), (0, 1))) / temperature
    shares = np.exp(values - values.max(1, keepdims=True))
    return np.asarray(shares / shares.sum(1, keepdims=True))


def confidence(shares: np.ndarray[Any, Any], truth: str) -> dict[str, float]:
    """Return ECE (15 bins), NLL and AURC."""
    wanted = np.array([int(d) for d in truth])
    top, right = shares.max(1), shares.argmax(1) == wanted
    bins = np.clip(np.ceil(top * 15).astype(int) - 1, 0, 14)
    gaps = [abs((right[bins == b] - top[bins == b]).sum()) for b in range(15)]
    risk = np.cumsum(~right[np.argsort(-top, kind="stable")]) / np.arange(1, len(right) + 1)
    own = np.maximum(shares[np.arange(len(wanted)), wanted], 1e-12)
    return {"ece": sum(gaps) / len(right), "nll": -np.log(own).mean(), "aurc": risk.mean()}


def drawn_scores(runs: Iterable[Said]) -> np.ndarray[Any, Any]:
    """Return (2, 1 + DRAWS) ACC and Macro-F1 in percent: as they are, then of every draw.

    A draw takes sources, seeds of each, and test objects of each class, all with replacement. They
    are the same for every row, so differences are paired.
    """
    runs = list(runs)
    sources, seeds = sorted({run[0] for run in runs}), sorted({run[1] for run in runs})
    cells = np.zeros((len(sources), len(seeds), 2, 1 + DRAWS))
    for source, seed, targets in runs:
        found = [_drawn(name, *target) for name, target in targets.items()]
        cells[sources.index(source), seeds.index(seed)] = np.mean(found, 0)
    dice = np.random.default_rng(7)
    chosen = dice.integers(len(sources), size=(DRAWS, len(sources), 1))
    which = dice.integers(len(seeds), size=(DRAWS, len(sources), len(seeds)))
    at = np.arange(1, 1 + DRAWS)[:, None, None]
    draws = cells[chosen, which, :, at].mean((1, 2)).T
    return 100 * np.column_stack((cells[..., 0].mean((0, 1)), draws))


def _drawn(domain: str, labels: str, guess: str, named: str) -> np.ndarray[Any, Any]:
    """Return (2, 1 + DRAWS) scores of a target whose objects are drawn within each class."""
    truth, objects = np.array(list(labels)), np.array(_numbers(named))
    weights = np.ones((1 + DRAWS, len(truth)), np.float32)
    for c in set(labels):
        own = np.unique(objects[truth == c])
        lots = np.random.default_rng([*domain.encode(), ord(c)])
        times = lots.multinomial(len(own), [1 / len(own)] * len(own), DRAWS)
        weights[1:, truth == c] = times[:, np.searchsorted(own, objects[truth == c])]
    names = np.array(sorted(set(labels)))
    is_so, said = (np.asarray(x[:, None] == names, np.float32) for x in (truth, np.array(list(guess))))
    right, each = weights @ (is_so * said), weights @ (is_so + said)
    accuracy = right.sum(1) / weights.sum(1)
    return np.stack((accuracy, (2 * right / np.maximum(each, 1e-9)).mean(1)))


def _numbers(text: str) -> list[int]:
    """Return the numbers of "3-5 9": 3, 4, 5, 9."""
    parts = [part.split("-") for part in text.split()]
    return [n for part in parts for n in range(int(part[0]), int(part[-1]) + 1)]
