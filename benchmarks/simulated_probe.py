"""The measures behind `benchmarks.simulated`: linear probes, three fusions, nearest neighbours."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.simulated_features import Array, Features, Names
from omnivat.kit.tables import need

Probabilities = Callable[[Array], NDArray[np.float64]]
FUSIONS = {
    "concatenation": "both, concatenated",
    "mean": "both, mean of unit vectors",
    "product": "both, product of probabilities",
}
READINGS = ("VIS", "TAC", *FUSIONS)
_SCARCE = "ceramic"  # a class that TacQuad lacks


@dataclass(frozen=True, slots=True, kw_only=True)
class Accuracy:
    """Correct predictions and their total."""

    right: int
    of: int

    @property
    def share(self) -> float:
        """Return the share of correct predictions, 0 to 1."""
        return self.right / self.of


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """Predictions of probes, each trained on one source domain.

    sources      the S domains
    predictions  reading -> (S, N) class names, "" for pairs that the source is not tested on
    """

    sources: tuple[str, ...]
    predictions: dict[str, Names]


def fitted(values: Array, materials: Names) -> tuple[Probabilities, Names]:
    """Return a linear probe of (N, D) training values, and its classes in order.

    Logistic regression of scikit-learn with C = 1, without scaling.
    """
    linear = need("sklearn.linear_model", purpose="the linear probe", install="scikit-learn")
    probe = linear.LogisticRegression(C=1.0, max_iter=3000)
    probe.fit(values, materials)
    return lambda others: np.asarray(probe.predict_proba(others)), np.asarray(probe.classes_)


def read_all(vis: Array, tac: Array, train: NDArray[np.bool_], materials: Names) -> dict[str, Names]:
    """Return the predictions of probes of every reading for all N pairs: reading -> (N,) classes.

    vis, tac   (N, D) unit-length embeddings
    train      (N,) the pairs that the probes are trained on
    materials  (N,) class names, read for training pairs only
    """
    inputs = {"VIS": vis, "TAC": tac, "concatenation": np.concatenate([vis, tac], axis=1), "mean": (vis + tac) / 2}
    shares, classes = {}, materials[:0]
    for name, values in inputs.items():
        probe, classes = fitted(values[train], materials[train])
        shares[name] = probe(values)
    shares["product"] = shares["VIS"] * shares["TAC"]
    return {name: np.asarray(classes[shares[name].argmax(1)]) for name in READINGS}


def judged(features: Features) -> Judged:
    """Return the predictions of probes trained on each domain, for its test pairs and other domains.

    Within a domain, its test pairs are predicted; in another domain, all its pairs, which are
    unseen. Ceramic is left out if the source or the target has none, as in the paper.
    """
    domains, materials = features.column("domain"), features.column("material")
    split = features.column("split")
    sources = tuple(dict.fromkeys(map(str, domains)))
    scarce = {name for name in sources if _SCARCE in materials[domains == name]}
    found: dict[str, list[Names]] = {name: [] for name in READINGS}
    for source in sources:
        row = {name: np.full(len(materials), "", dtype=materials.dtype) for name in READINGS}
        for whole in (True, False) if source in scarce else (False,):
            kept = np.full(len(materials), whole) | (materials != _SCARCE)
            train = (domains == source) & (split == "train") & kept
            here = kept & ((domains != source) | (split == "test"))
            if source in scarce:
                here &= np.isin(domains, list(scarce)) == whole
            predicted = read_all(features.vis, features.tac, train, materials)
            for name in READINGS:
                row[name][here] = predicted[name][here]
        for name in READINGS:
            found[name].append(row[name])
    return Judged(sources=sources, predictions={n: np.stack(rows) for n, rows in found.items()})


def sensor_accuracy(tac: Array, *, domains: Names, splits: Names) -> dict[str, Accuracy]:
    """Return, by domain, how often the nearest training image of a test image has its domain."""
    train, test = splits == "train", splits == "test"
    nearest = domains[train][(tac[test] @ tac[train].T).argmax(1)]
    return {
        str(name): Accuracy(
            right=int((nearest[domains[test] == name] == name).sum()), of=int((domains[test] == name).sum())
        )
        for name in dict.fromkeys(domains)
    }
