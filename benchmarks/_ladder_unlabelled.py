"""The test-time methods of `benchmarks.ladder`, which learn from a target's pairs without labels."""

import numpy as np

from benchmarks._ladder_methods import Array, Pair, Profiles, Trained, closed, unit

NEIGHBOURS, FILTER = 5, 20  # of LAME; of T3A, pictures a class


def t3a(method: Trained, own: Pair, labels: Array, new: Pair, asked: Pair) -> Array:
    """Return answers of T3A (Iwasawa and Matsuo, NeurIPS 2021), with class means for weights.

    own, labels  the source's training pairs: their class means start the support sets
    new          the target's pairs without labels; the 20 surest of a class join its set
    """
    first, found = unit(method.features(own)), unit(method.features(new))
    shares = method.probabilities(new)
    entropy = -(shares * np.log(np.maximum(shares, 1e-12))).sum(1)
    said, centres = shares.argmax(1), []
    for c in range(shares.shape[1]):
        sure = np.flatnonzero(said == c)[np.argsort(entropy[said == c])][:FILTER]
        start = unit(first[labels == c].sum(0, keepdims=True))
        centres.append(np.vstack([start, found[sure]]).mean(0))
    answers: Array = (unit(method.features(asked)) @ unit(np.stack(centres)).T).argmax(1)
    return answers


def lame(method: Trained, new: Pair, asked: Pair) -> Array:
    """Return answers of LAME (Boudiaf et al., CVPR 2022), over unlabelled and asked pairs together."""
    both = (np.vstack([new[0], asked[0]]), np.vstack([new[1], asked[1]]))
    logs = np.log(np.maximum(method.probabilities(both), 1e-12))
    features = unit(method.features(both))
    near = features @ features.T
    np.fill_diagonal(near, -np.inf)
    kept = np.argsort(-near, 1)[:, :NEIGHBOURS]
    affinity = np.zeros_like(near)
    np.put_along_axis(affinity, kept, 1.0, 1)
    affinity = (affinity + affinity.T) / 2
    shares = np.exp(logs)
    for _ in range(100):
        before, scores = shares, logs + affinity @ shares
        shares = np.exp(scores - scores.max(1, keepdims=True))
        shares /= shares.sum(1, keepdims=True)
        if np.abs(shares - before).max() < 1e-6:
            break
    answers: Array = shares[len(new[0]) :].argmax(1)
    return answers


def self_trained(name: str, own: Pair, labels: Array, new: Pair, asked: Pair, source: Profiles, classes: int) -> Array:
    """Return answers after two rounds of self-training (pseudo-labels; Lee, 2013): half, then 70 %."""
    model = closed(name, own, labels, source, classes)
    for share in (0.5, 0.7):
        found = model.probabilities(new)
        sure = np.argsort(-found.max(1))[: round(share * len(found))]
        both = (np.vstack([own[0], new[0][sure]]), np.vstack([own[1], new[1][sure]]))
        model = closed(name, both, np.r_[labels, found.argmax(1)[sure]], source, classes)
    return model.predict(asked)
