"""The measures behind `benchmarks.simulated`: linear probes and nearest neighbours."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from omnivat.packages import need

Array = NDArray[np.float32]
Names = NDArray[np.str_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Accuracy:
    """How many were right, of how many."""

    right: int
    of: int

    @property
    def share(self) -> float:
        """Return the share that was right, 0 to 1."""
        return self.right / self.of


def accuracy(right: int, of: int) -> Accuracy:
    """Return the two counts as one value."""
    return Accuracy(right=int(right), of=int(of))


def fitted(values: Array, materials: Names, strength: float = 1.0) -> Callable[[Array], Names]:
    """Return a linear probe of (N, D) training values: what material it says of others.

    Logistic regression as scikit-learn has it; its C is `strength`, by default as there.
    """
    linear = need("sklearn.linear_model", purpose="the linear probe", install="scikit-learn")
    mean, spread = values.mean(0), values.std(0) + 1e-3
    probe = linear.LogisticRegression(C=strength, max_iter=1000)
    probe.fit((values - mean) / spread, materials)
    return lambda others: np.asarray(probe.predict((others - mean) / spread))


def probe_matrix(
    values: Array, *, materials: Names, domains: Names, splits: Names
) -> dict[tuple[str, str], Accuracy]:
    """Train a linear probe on each domain's training objects; return its accuracy on each domain.

    values   (N, D). Standardised with the mean and spread that the probe was trained on.
    Within a domain the test objects are asked; in another domain all its pairs, none of which was
    seen. Ceramic is left out where the source or the target has none, as the paper does.
    """
    names = list(dict.fromkeys(map(str, domains)))
    result = {}
    for source in names:
        known = (domains == source) & (splits == "train")
        for with_all in (True, False):
            train = known & (with_all | (materials != "ceramic"))
            if with_all and "ceramic" not in materials[known]:
                continue
            probe = fitted(values[train], materials[train])
            for target in names:
                there = domains == target
                if ("ceramic" in materials[there]) != with_all and "ceramic" in materials[known]:
                    continue
                asked = there & ((splits == "test") | (source != target))
                asked &= np.isin(materials, materials[train])
                right = probe(values[asked]) == materials[asked]
                result[source, target] = accuracy(right.sum(), right.size)
    return {pair: result[pair] for pair in ((s, t) for s in names for t in names)}


def cross_validated(
    values: Array, *, materials: Names, objects: Names, strength: float, folds: int = 5
) -> Accuracy:
    """Return the accuracy on held-out fifths of the objects, probes trained on the other four."""
    things = dict.fromkeys(zip(map(str, materials), map(str, objects), strict=True))
    fold_of = {thing: number % folds for number, (_, thing) in enumerate(sorted(things))}
    fold = np.array([fold_of[str(name)] for name in objects])
    right = [
        fitted(values[fold != k], materials[fold != k], strength)(values[fold == k])
        == materials[fold == k]
        for k in range(folds)
    ]
    return accuracy(sum(int(part.sum()) for part in right), len(values))


def within_with(
    values: Array, *, materials: Names, domains: Names, splits: Names, objects: Names, count: int
) -> dict[str, Accuracy]:
    """Return, by domain, the accuracy on its test objects after `count` training objects a class."""
    few = np.zeros(len(values), dtype=bool)
    for domain in dict.fromkeys(map(str, domains)):
        for material in dict.fromkeys(map(str, materials)):
            mine = (domains == domain) & (materials == material) & (splits == "train")
            few |= mine & np.isin(objects, list(dict.fromkeys(map(str, objects[mine])))[:count])
    result = {}
    for domain in dict.fromkeys(map(str, domains)):
        here = domains == domain
        asked = here & (splits == "test")
        right = fitted(values[here & few], materials[here & few])(values[asked]) == materials[asked]
        result[domain] = accuracy(right.sum(), right.size)
    return result


def sensor_accuracy(tac: Array, *, domains: Names, splits: Names) -> dict[str, Accuracy]:
    """Return, by domain, how often the nearest training image of a test image is of its domain."""
    train, test = splits == "train", splits == "test"
    nearest = domains[train][(tac[test] @ tac[train].T).argmax(1)]
    return {
        str(name): accuracy(
            (nearest[domains[test] == name] == name).sum(), (domains[test] == name).sum()
        )
        for name in dict.fromkeys(domains)
    }
