"""The measures behind `benchmarks.simulated`: linear probes and nearest neighbours."""

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


def probe_matrix(
    values: Array, *, materials: Names, domains: Names, splits: Names
) -> dict[tuple[str, str], Accuracy]:
    """Train a linear probe on each domain's training objects; return its accuracy on each domain.

    values   (N, D). Standardised with the source's training mean and spread.
    Within a domain the test objects are asked; in another domain all its pairs, none of which was
    seen. Ceramic is left out where the source or the target has none, as the paper does.
    """
    linear = need("sklearn.linear_model", purpose="the linear probe", install="scikit-learn")
    names = list(dict.fromkeys(map(str, domains)))
    result = {}
    for source in names:
        known = (domains == source) & (splits == "train")
        mean, spread = values[known].mean(0), values[known].std(0) + 1e-3
        scaled = (values - mean) / spread
        for with_all in (True, False):
            train = known & (with_all | (materials != "ceramic"))
            if with_all and "ceramic" not in materials[known]:
                continue
            probe = linear.LogisticRegression(C=1e-3, max_iter=300)
            probe.fit(scaled[train], materials[train])
            for target in names:
                there = domains == target
                if ("ceramic" in materials[there]) != with_all and "ceramic" in materials[known]:
                    continue
                asked = there & ((splits == "test") | (source != target))
                asked &= np.isin(materials, materials[train])
                right = probe.predict(scaled[asked]) == materials[asked]
                result[source, target] = accuracy(right.sum(), right.size)
    return {pair: result[pair] for pair in ((s, t) for s in names for t in names)}


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
